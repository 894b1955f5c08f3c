"""What an accepted RAPID program becomes is a motion that the robot can make, as it was programmed."""

import numpy as np
import pytest
from generated_programs import SPEEDS, ZONES, programs
from hypothesis import HealthCheck, given, settings

from ffgym.core.errors import FFGymError
from ffgym.paths.limits import MotionLimits
from ffgym.paths.motions import compose, load_motion
from ffgym.paths.motions.composition import rapid_motion
from ffgym.paths.rapid import on_branches, parse_program

HOME = """PROC main()
MoveAbsJ [[0, 10, 15, 0, 35, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]], v200, {}, tool0;
{}
ENDPROC
PROC wrist()
MoveAbsJ [[0, 10, 15, 0, 35, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]], v200, fine, tool0;
MoveAbsJ [[0, 10, 15, 90, 35, 90], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]], vmax, fine, tool0;
ENDPROC
"""


def written(tmp_path, text):
    path = tmp_path / "cut.mod"
    path.write_text(text, encoding="utf-8")
    return path


def motion_of(arm, generated):
    execution = parse_program(generated.text, "generated.mod").execute(arm.robot)
    return compose(arm, on_branches(arm, execution)[0])


def phases_of(reference, targets):
    """Phase of each target but the first, where the motion starts."""
    return [next(p for p in reference.phases if p.label == f"p{i}") for i in range(1, len(targets))]


def row_after(reference, phase):
    """First sample at or after the end of a phase."""
    return int(np.ceil(phase.end / reference.t[1] - 1e-6))


def many(check):
    """The same question to few programs always, and to many where there is time."""
    quick = settings(max_examples=6, suppress_health_check=list(HealthCheck))
    thorough = settings(max_examples=60, suppress_health_check=list(HealthCheck))
    cases = [pytest.param(quick, id="few"), pytest.param(thorough, id="many", marks=pytest.mark.slow)]
    return pytest.mark.parametrize("effort", cases)(check)


@many
def test_motions_are_continuous_and_within_the_limits_of_every_joint(arm, effort):
    kinematics = arm.robot.kinematics
    limits = MotionLimits().of_joints(kinematics.max_speed)
    dt = arm.robot.servo.control_dt

    @effort
    @given(programs())
    def ask(generated):
        r = motion_of(arm, generated).reference
        assert np.all((r.q >= kinematics.range[:, 0]) & (r.q <= kinematics.range[:, 1]))
        assert np.all(np.abs(r.dq) <= limits.speed)
        assert np.all(np.abs(r.ddq) <= limits.acceleration)
        assert np.all(np.abs(np.diff(r.ddq, axis=0)) <= limits.jerk * dt)
        apart = np.diff(r.q, axis=0) - dt * (r.dq[1:] + r.dq[:-1]) / 2
        assert np.all(np.abs(apart) <= limits.jerk * dt**3 / 12 + 1e-9)  # the error of the trapezoid rule
        for row in (0, -1):
            np.testing.assert_array_equal(r.dq[row], 0)
            np.testing.assert_array_equal(r.ddq[row], 0)

    ask()


@many
def test_the_tool_is_never_faster_than_programmed(arm, effort):
    @effort
    @given(programs())
    def ask(generated):
        r = motion_of(arm, generated).reference
        speed = np.linalg.norm(np.einsum("tij,tj->ti", arm.jacobian(r.q), r.dq)[:, :3], axis=1)
        for target, phase in zip(generated.targets[1:], phases_of(r, generated.targets), strict=True):
            rows = (r.t >= phase.start) & (r.t <= phase.end)
            assert np.all(speed[rows] <= SPEEDS[target.speed] * 1e-3 * (1 + 1e-6))

    ask()


@many
def test_the_robot_rests_at_fine_points_and_passes_the_others_within_their_zones(arm, effort):
    @effort
    @given(programs())
    def ask(generated):
        r = motion_of(arm, generated).reference
        tcp = arm.tcp_position(r.q) * 1e3
        for target, phase in zip(generated.targets[1:], phases_of(r, generated.targets), strict=True):
            row = row_after(r, phase)
            away = np.linalg.norm(tcp[row - 1 : row + 2] - target.position, axis=1).min()
            step = SPEEDS[target.speed] * r.t[1]
            if target.zone == "fine":
                np.testing.assert_array_equal(r.dq[row], 0)
                assert np.linalg.norm(tcp[row] - target.position) < 1e-5
            else:
                assert away <= ZONES[target.zone] + step

    ask()


@settings(max_examples=5, suppress_health_check=list(HealthCheck))
@given(programs())
def test_phases_follow_the_program_in_its_order(arm, generated):
    r = motion_of(arm, generated).reference
    order = [p.label for p in r.phases if p.label.startswith("p")]
    assert order == [f"p{i}" for i in range(1, len(generated.targets))]
    rests = generated.text.count("WaitTime")
    assert len([p for p in r.phases if p.label.startswith("wait")]) == rests


def test_zones_larger_than_what_lies_between_their_targets_shrink(arm):
    """A staircase of steps of 2 mm under zones of 20 mm: corners follow each other, nothing is left between them."""
    target = "[[{}, {}, 700], [0, 0, 1, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]]"
    steps = [target.format(1500 + 2 * ((i + 1) // 2), 2 * (i // 2)) for i in range(12)]
    body = "".join(f"MoveL {step}, v50, z20, tRobot;\n" for step in steps)
    text = f"PROC main()\nConfJ \\Off;\nMoveJ {steps[0]}, v50, fine, tRobot;\n{body}ENDPROC"
    execution = parse_program(text).execute(arm.robot)
    r = compose(arm, on_branches(arm, execution)[0]).reference
    offset = arm.tcp_position(r.q) * 1e3 - [1500, 0, 700]
    assert np.abs(offset[:, 2]).max() < 1e-6
    assert np.abs(offset[:, 0] - offset[:, 1] - 1).max() <= 1 + 1e-6
    np.testing.assert_allclose(offset[-1], [12, 10, 0], atol=1e-6)
    limits = MotionLimits().of_joints(arm.robot.kinematics.max_speed)
    assert np.all(np.abs(np.diff(r.ddq, axis=0)) <= limits.jerk * r.t[1])


def test_a_file_is_found_by_its_suffix_and_names_its_motion(arm, tmp_path):
    motion = load_motion(arm, written(tmp_path, HOME.format("fine", "wrist;")))
    assert motion.reference.name == "cut"
    assert motion.reference.duration > 1
    np.testing.assert_allclose(motion.reference.q[0], np.deg2rad([0, 10, 15, 0, 35, 0]), atol=1e-12)
    np.testing.assert_allclose(motion.reference.q[-1], np.deg2rad([0, 10, 15, 90, 35, 90]), atol=1e-12)
    old = tmp_path / "CUT.PRG"
    old.write_bytes((tmp_path / "cut.mod").read_bytes())
    assert load_motion(arm, old).reference.duration == motion.reference.duration


def test_another_procedure_can_be_the_entry(arm, tmp_path):
    path = written(tmp_path, HOME.format("fine", "PDispOff;"))
    assert rapid_motion(arm, path, entry="Wrist").reference.duration > 1
    with pytest.raises(FFGymError, match=r"^cut.mod:3:1: PDispOff is not supported"):
        rapid_motion(arm, path)


def test_limits_of_the_motion_are_obeyed(arm, tmp_path):
    path = written(tmp_path, HOME.format("fine", "wrist;"))
    slow = rapid_motion(arm, path, limits=MotionLimits(joint_speed=0.1)).reference
    assert np.abs(slow.dq / arm.robot.kinematics.max_speed).max() <= 0.1
    assert slow.duration > 2 * rapid_motion(arm, path).reference.duration


def test_the_robot_of_the_motion_holds_the_tool_of_the_program(arm, tmp_path):
    tool = "PERS tooldata tPen := [TRUE, [[0, 0, 200], [1, 0, 0, 0]], [1, [0, 0, 60], [1, 0, 0, 0], 0, 0, 0]];\n"
    text = tool + HOME.format("fine", "wrist;").replace("vmax, fine, tool0", "vmax, fine, tPen")
    robot = load_motion(arm, written(tmp_path, text)).reference.robot
    assert robot.tool.mass == 1
    assert arm.robot.tool.mass == 8


CORNERS = {
    "out of reach": ("fine", "MoveL {far}, v100, fine, tRobot;", r"3:1: .*reach"),
    "points on a line": ("fine", "MoveL {a}, v100, fine, tRobot; MoveC {b}, {c}, v100, fine, tRobot;", "3:89: .*line"),
    "a joint limit": ("fine", "MoveAbsJ {beyond}, v100, fine, tool0;", "3:1: .*range"),
}


@pytest.mark.parametrize(("zone", "body", "message"), CORNERS.values(), ids=list(CORNERS))
def test_what_the_arm_cannot_do_is_one_error_with_its_place(arm, tmp_path, zone, body, message):
    def target(x):
        return f"[[{x},0,700],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"

    joints = "[[0,10,15,0,135,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    body = body.format(a=target(1500), b=target(1510), c=target(1520), far=target(9000), beyond=joints)
    with pytest.raises(FFGymError, match=rf"^cut.mod:{message}"):
        load_motion(arm, written(tmp_path, HOME.format(zone, body)))


def test_where_the_robot_stops_although_it_was_not_asked_to_a_note_says_so(arm, tmp_path):
    target = "[[1500,0,700],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    motion = load_motion(arm, written(tmp_path, HOME.format("fine", f"MoveL {target}, v100, z10, tRobot;\nwrist;")))
    assert len(motion.notes) == 1
    assert motion.notes[0].startswith("cut.mod:3:1: the robot stops at ")
