"""Results of any motion as plain text for a terminal, at most 120 columns wide."""

from collections.abc import Callable, Sequence

from ffgym.report.circles.tables import Column, aligned, filled, shortened
from ffgym.report.laws import law_styles
from ffgym.studies import MotionResult, MotionStudy


def format_motion(study: MotionStudy) -> str:
    """For each motion: path error, motor errors, and how much of the limits is used, one line per law."""
    return "\n".join(_motion_text(study, name) for name in study.references)


def _motion_text(study: MotionStudy, name: str) -> str:
    results = [result for result in study.results if result.motion == name]
    reference, joints = study.references[name], study.robot.joints
    title = f"{name}: {reference.duration:.2f} s, {study.robot.title}"
    parts = [title, "-" * min(len(title), 120)]
    if results[0].path:
        parts += [_path_text(results), ""]
    parts += [
        filled(
            "Motor error [mrad]: reference minus motor, motor side, RMS (max), without standstill. Torque: largest "
            "asked of the drive, in percent of its peak torque. Speed: largest of the reference, in percent of the "
            "limit."
        ),
        "",
        _joint_text(results, joints, "motor error [mrad]", _motor_error),
        "",
        _joint_text(results, joints, "torque [%]", lambda result, j: f"{result.torque_use[j]:.1%}"),
        "",
        _joint_text(results[:1], joints, "speed [%]", lambda result, j: f"{result.speed_use[j]:.1%}", "all laws"),
    ]
    return "\n".join(parts) + "\n"


def _path_text(results: Sequence[MotionResult]) -> str:
    legend = filled(
        "Path error [mm]: distance of the tool from the nearest point of its path, in space, and how far it is behind "
        "or ahead along the path; offset at the start removed, without standstill."
    )
    whole = [result.path[0] for result in results]
    columns: list[Column] = [
        ("RMS", [f"{stretch.rms_mm:.3f}" for stretch in whole]),
        ("max", [f"{stretch.max_mm:.3f}" for stretch in whole]),
        ("along: RMS", [f"{stretch.lag_rms_mm:.3f}" for stretch in whole]),
        ("max", [f"{stretch.lag_max_mm:.3f}" for stretch in whole]),
    ]
    return f"{legend}\n\n{aligned([('path error [mm]', _labels(results))], [columns])}"


def _joint_text(
    results: Sequence[MotionResult],
    joints: Sequence[str],
    heading: str,
    cell: Callable[[MotionResult, int], str],
    label: str = "",
) -> str:
    """One column per joint; `label` stands for the laws where they do not differ."""
    blocks: list[list[Column]] = [
        [(shortened(joint), [cell(result, j) for result in results])] for j, joint in enumerate(joints)
    ]
    return aligned([(heading, [label] if label else _labels(results))], blocks)


def _motor_error(result: MotionResult, joint: int) -> str:
    return f"{result.motor_rms_rad[joint] * 1e3:.2f} ({result.motor_max_rad[joint] * 1e3:.2f})"


def _labels(results: Sequence[MotionResult]) -> list[str]:
    styles = law_styles(result.agent for result in results)
    return [shortened(styles[result.agent].label) for result in results]
