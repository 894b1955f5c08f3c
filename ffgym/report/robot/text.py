"""What a robot check found, in sentences and as text for a terminal."""

from ffgym.report.circles.tables import Column, aligned, filled
from ffgym.report.robot.tables import FactTable, robot_tables
from ffgym.studies.robot_check import RobotCheck, ServoLoop


def format_check(check: RobotCheck) -> str:
    """The check as text, at most 120 columns wide."""
    parts = [filled(" ".join(facts(check)))]
    for table in robot_tables(check):
        parts.append("\n".join([table.title, "-" * len(table.title), _columns(table)]))
        if table.note:
            parts.append(filled(table.note))
    doubts = [f"- {doubt}" for doubt in check.doubts] or ["none"]
    parts.append("\n".join(["Doubts", "------", *(filled(doubt) for doubt in doubts)]))
    return "\n\n".join(parts) + "\n"


def facts(check: RobotCheck) -> list[str]:
    """Sentences about the robot as a whole."""
    draft = check.draft
    state = "complete" if not draft.missing else f"{len(draft.missing)} entries missing"
    found = [f"{draft.title} ({draft.name}), {len(draft.joints)} joint{'s' if len(draft.joints) > 1 else ''}: {state}."]
    if draft.missing:
        found.append(f"Missing: {', '.join(draft.missing)}.")
    if check.mass is not None:
        found.append(f"The joints carry {check.mass:.4g} kg.")
    if check.reach is not None and check.reach.distance > 0:
        reach, what = check.reach, _tip(check)
        box = ", ".join(f"{n} {a:.2f} to {b:.2f}" for n, a, b in zip("xyz", reach.low, reach.high, strict=True))
        found.append(f"{what} comes up to {reach.distance:.3g} m away from the first joint, within {box} m.")
    if check.servo is not None and not check.servo.problem:
        found.append(_servo(check.servo))
    return found


def _servo(servo: ServoLoop) -> str:
    if not servo.stable:
        return f"Servo unstable at {servo.place}, without friction."
    margin = "more than 100" if servo.gain_margin is None else f"{servo.gain_margin:.3g}"
    return (
        f"Servo stable at {servo.place} up to {margin} times the gains; least damped oscillation "
        f"{servo.frequency:.3g} Hz with damping ratio {servo.damping:.2g}, without friction."
    )


def _columns(table: FactTable) -> str:
    columns: list[Column] = [(heading, [row[k] for row in table.rows]) for k, heading in enumerate(table.headings)]
    return aligned(columns[:1], [[column] for column in columns[1:]])


def _tip(check: RobotCheck) -> str:
    return "The TCP" if "tool.tcp" in check.draft.quantities and check.draft.can("kinematics") else "The last link"
