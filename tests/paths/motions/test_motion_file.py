"""Motion files: every kind of part, names and units, and one clear error for what is wrong."""

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.paths import circle_test, joint_sine
from ffgym.paths.motions import compose, load_motion
from ffgym.paths.motions.load import PARTS, parse_motion
from ffgym.paths.motions.part import entries, joint_values, rotation_of
from ffgym.robot import RigidArm

POINT = np.array([1.3, -0.2, 0.6])
LINE = '[[part]]\nkind = "line"\nto = [{}]\nspeed = 0.1\n'


def motion(arm, text):
    return parse_motion(arm, text, where="job.toml", name="job")


def reference(arm, text):
    return motion(arm, text).reference


def one_part(kind, **values):
    return f'[[part]]\nkind = "{kind}"\n' + "".join(f"{name} = {value}\n" for name, value in values.items())


TO_START = LINE.format("0, 0, 0")
AT = 'origin = "p1"\n'


def test_points_count_from_the_origin_and_names_are_points_of_the_work_area(arm, irb4600):
    there = reference(arm, AT + LINE.format("0.05, 0, 0"))
    np.testing.assert_allclose(arm.tcp_position(there.q[:1])[0], POINT + np.array([0.05, 0, 0]), atol=1e-9)
    named = reference(arm, AT + one_part("line", to='"p2"', speed=0.1))
    np.testing.assert_allclose(arm.tcp_position(named.q[:1])[0], irb4600.work_area.positions["p2"], atol=1e-9)
    first = reference(arm, 'origin = "work_area"\n' + TO_START)
    world = reference(arm, LINE.format("1.3, -0.2, 0.6"))
    np.testing.assert_array_equal(first.q, world.q)


def test_lines_and_arcs_with_zones_and_orientations(arm):
    text = (
        AT
        + TO_START
        + one_part("line", to="[0.1, 0, 0]", speed=0.1, zone=0.01, label='"edge"')
        + one_part("arc", via="[0.15, 0.05, 0]", to="[0.1, 0.1, 0]", speed=0.1, rpy_deg="[0, 80, 0]")
    )
    made = reference(arm, text)
    assert [p.label for p in made.phases] == ["rest 0", "edge", "move 3", "rest 1"]
    position, rotation = (part[0] for part in arm.tcp_pose(made.q[-1:]))
    np.testing.assert_allclose(position, POINT + np.array([0.1, 0.1, 0]), atol=1e-9)
    np.testing.assert_allclose(rotation, rotation_of([0, 80, 0], None), atol=1e-9)


def test_a_circle_lies_in_its_plane_and_has_its_phase(arm):
    made = reference(arm, AT + one_part("circle", centre='"p1"', radius=0.02, speed=0.1, normal="[1, 0, 0]", turns=2))
    circles = [p for p in made.phases if p.kind == "circle"]
    assert [p.label for p in circles] == ["circle 20 mm"] * 2
    tcp = arm.tcp_position(made.q) - POINT
    np.testing.assert_allclose(np.linalg.norm(tcp, axis=1), 0.02, atol=1e-9)
    np.testing.assert_allclose(tcp[:, 0], 0, atol=1e-9)


def test_a_spline_goes_through_its_points(arm):
    made = reference(arm, AT + one_part("spline", through='["p1", [0.05, 0.05, 0], [0.1, 0, 0]]', speed=0.1))
    tcp = arm.tcp_position(made.q) - POINT
    assert np.linalg.norm(tcp - [0.05, 0.05, 0], axis=1).min() < 1e-3
    np.testing.assert_allclose(tcp[[0, -1]], [[0, 0, 0], [0.1, 0, 0]], atol=1e-9)


def test_the_circle_test_and_the_sine_are_those_of_the_thesis(arm, one_axis):
    made = reference(arm, one_part("circle_test", speed=0.04, radii="[0.003]"))
    path = circle_test(POINT, 0.04, radii=(0.003,))
    assert [(p.label, p.start, p.end) for p in made.phases] == [(p.label, p.start, p.end) for p in path.phases]
    np.testing.assert_allclose(arm.tcp_position(made.q), path.position, atol=1e-9)
    sine = reference(RigidArm(one_axis), one_part("sine", amplitude=0.1, frequency=3.0, duration=2.0))
    np.testing.assert_array_equal(sine.q, joint_sine([0.1], 3.0, 2.0).q)


def test_joint_parts_take_numbers_lists_tables_and_shares(arm, irb4600):
    home, joints = irb4600.work_area.home, irb4600.joints
    text = one_part("joints", to="[0, 0, 0, 0, 0.5, 0]") + one_part("joints", to_deg=f"{{ {joints[0]} = 10.0 }}")
    made = reference(arm, text)
    np.testing.assert_allclose(made.q[-1], [np.deg2rad(10), *home[1:]], atol=1e-12)
    whole = np.arange(1.0, 7.0)
    np.testing.assert_array_equal(joint_values(irb4600, "x", "10 %", whole), 0.1 * whole)
    np.testing.assert_array_equal(joint_values(irb4600, "x", 2, whole), np.full(6, 2.0))
    mixed = joint_values(irb4600, "x", {joints[1]: "50 %", joints[2]: 7}, whole)
    np.testing.assert_array_equal(mixed, [0, 1, 7, 0, 0, 0])


@pytest.mark.parametrize("kind", ["multisine", "ladder", "triangle"])
def test_excitations_start_where_the_robot_is_and_return_there(arm, irb4600, kind):
    values = {
        "multisine": {"amplitude": '"0.1 %"', "frequencies": "[0.5, 1.0]", "duration": 2.0},
        "ladder": {"speeds": '["5 %"]', "travel": 0.1},
        "triangle": {"amplitude": 0.05, "period": 2.0},
    }[kind]
    start = np.array([0.1, 0.1, 0.3, 0.2, 0.4, -0.3])
    made = reference(arm, one_part("joints", to=start.tolist()) + one_part(kind, **values))
    np.testing.assert_allclose(made.q[[0, -1]], [start, start], atol=1e-9)
    assert made.phases[0].kind == made.phases[-1].kind == "standstill"
    alone = reference(arm, one_part(kind, **values))
    np.testing.assert_allclose(alone.q[0], irb4600.work_area.home, atol=1e-12)
    told = reference(arm, one_part(kind, centre=start.tolist(), **values))
    np.testing.assert_allclose(told.q[0], start, atol=1e-12)


def test_sines_may_have_sizes_and_phases_of_their_own(one_axis):
    arm = RigidArm(one_axis)
    made = reference(
        arm,
        one_part(
            "multisine",
            amplitude="[[0.1], [0.05]]",
            frequencies="[1.0, 2.0]",
            phases="[0.0, 1.0]",
            duration=3.0,
            ramp=0.5,
            dwell=0.1,
        ),
    )
    t = made.t[(made.t > 0.7) & (made.t < 2.5)]
    wanted = 0.1 * np.sin(2 * np.pi * (t - 0.1)) + 0.05 * np.sin(4 * np.pi * (t - 0.1) + 1)
    np.testing.assert_allclose(made.q[(made.t > 0.7) & (made.t < 2.5), 0], wanted, atol=1e-9)


def test_limits_start_dwell_and_name_come_from_the_file(arm, corners):
    start = corners["p1"].tolist()
    head = f'name = "slow job"\nstart = {start}\ndwell = 0.1\n{AT}[limits]\nacceleration = 0.2\njoint_jerk = "1000 %"\n'
    slow = reference(arm, head + LINE.format("0.1, 0, 0"))
    fast = reference(arm, AT + f"start = {start}\n" + LINE.format("0.1, 0, 0"))
    assert slow.name == "slow job"
    assert slow.phases[0].end == pytest.approx(0.1)
    assert slow.duration - 0.2 > fast.duration - 0.6


def test_a_file_is_read_from_its_folder_with_its_tables(arm, tmp_path):
    (tmp_path / "points.csv").write_text("x_mm,y_mm,z_mm\n1300,-200,600\n1350,-150,600\n1400,-200,600\n")
    (tmp_path / "job.toml").write_text(one_part("table", file='"points.csv"', speed=0.2))
    made = load_motion(arm, tmp_path / "job.toml")
    assert made.reference.name == "job"
    assert made.reference.phases[1].label == "points"
    direct = load_motion(arm, str(tmp_path / "points.csv"))
    assert direct.reference.duration > made.reference.duration


BAD = {
    "not TOML": ("kind = ", "job.toml is not valid TOML"),
    "no parts": ('name = "x"\n', "job.toml: A motion file needs parts"),
    "parts that are no tables": ("part = [1]\n", "job.toml: A motion file needs parts"),
    "unknown entry": (
        'speed = 1\n[[part]]\nkind = "wait"\nduration = 1',
        "Unknown entries speed. A motion file has name",
    ),
    "no kind": ("[[part]]\nto = [0, 0, 0]\n", "job.toml: part 1: Unknown kind of part None"),
    "unknown kind": ('[[part]]\nkind = "zigzag"\n', "part 1 .zigzag.: Unknown kind of part 'zigzag'. Available: arc"),
    "kind is a list": ("[[part]]\nkind = [1]\n", "Unknown kind of part"),
    "missing entry": ('[[part]]\nkind = "line"\nto = [0, 0, 0]\n', "part 1 .line.: Missing entries: speed"),
    "unknown part entry": (TO_START + "tempo = 3\n", "part 1 .line.: Unknown entries tempo. A line has speed"),
    "bad point": (one_part("line", to="[0, 0]", speed=0.1), "part 1 .line.: to has shape"),
    "unknown point": (one_part("line", to='"q1"', speed=0.1), "Unknown point 'q1'. Available"),
    "bad speed": (one_part("line", to="[0, 0, 0]", speed=-1), "speed = -1.0 m/s is out of range"),
    "bad turn speed": (one_part("line", to="[0, 0, 0]", speed=1, turn_speed_deg=0), "turn_speed_deg"),
    "bad zone": (one_part("line", to="[0, 0, 0]", speed=1, zone=-1), "zone = -1.0 m is out of range"),
    "label is a number": (one_part("line", to="[0, 0, 0]", speed=1, label=3), "label = 3 must be text"),
    "quaternion": (one_part("line", to="[0, 0, 0]", speed=1, quaternion="[1, 1, 0, 0]"), "must have norm 1"),
    "two orientations": (
        one_part("line", to="[0, 0, 0]", speed=1, quaternion="[1, 0, 0, 0]", rpy_deg="[0, 0, 0]"),
        "give one of them",
    ),
    "two targets": (one_part("joints", to=0, to_deg=0), "needs either to"),
    "unknown joint": (one_part("joints", to="{ j9 = 1 }"), "Unknown joint in to: 'j9'"),
    "too few joints": (one_part("joints", to="[1, 2]"), "to .one entry for each of"),
    "no share": (one_part("joints", to='"ten"'), "must be numbers, or a share such as '10 %'"),
    "nan": (one_part("joints", to="nan"), "to must be finite"),
    "amplitudes": (one_part("multisine", amplitude="[[1]]", frequencies="[1, 2]", duration=3), "one for each of 2"),
    "phases": (one_part("multisine", amplitude=0.1, frequencies="[1]", duration=3, phases='"any"'), "Unknown phases"),
    "ladder": (one_part("ladder", speeds=1, travel=1), "must be a list of steps"),
    "spline": (one_part("spline", through="3", speed=1), "must be a list of points"),
    "closed": (one_part("spline", through="[[0, 0, 0]]", speed=1, closed='"yes"'), "must be true or false"),
    "turns": (one_part("circle", centre="[1, 0, 0]", radius=0.1, speed=1, turns=0), "turns"),
    "radius": (one_part("circle", centre="[1, 0, 0]", radius=0, speed=1), "radius"),
    "no file": (one_part("table", file='"no.csv"'), "no.csv: cannot be read"),
    "file is a number": (one_part("table", file=3), "must be the path of a CSV file"),
    "origin": ('origin = "q9"\n' + TO_START, "Unknown point 'q9'"),
    "origin shape": ("origin = [1]\n" + TO_START, "origin has shape"),
    "limits": ("limits = 3\n" + TO_START, "must be a table"),
    "unknown limit": ("[limits]\nspeed = 3\n" + TO_START, "Unknown limit 'speed'"),
    "bad limit": ("[limits]\njerk = 0\n" + TO_START, "jerk = 0.0 m/s"),
    "dwell": ("dwell = -1\n" + TO_START, "dwell"),
    "start": ("start = [1]\n" + TO_START, "start .one entry"),
    "name": ("name = 3\n" + TO_START, "name = 3 must be text"),
    "another planet": (LINE.format("1e200, 0, 0"), "is beyond 1000 m; is it in another unit"),
    "beyond the speed of sound": (one_part("line", to="[0, 0, 0]", speed=1e308), "speed = 1e.308 m/s is out of range"),
    "forever": (AT + TO_START + one_part("line", to="[0.1, 0, 0]", speed=1e-300), "speed|would last"),
    "an endless wait": (AT + TO_START + one_part("wait", duration=1e300), "The motion would last 1e.300 s"),
    "an endless triangle": (one_part("triangle", amplitude=0.1, period=2, periods="1_000_000_000"), "n_periods"),
    "an endless circle": (one_part("circle", centre='"p1"', radius=0.1, speed=1, turns="1_000_000_000"), "turns"),
    "huge circle": (one_part("circle", centre='"p1"', radius=1e308, speed=1), "radius"),
    "huge joints": (one_part("joints", to=1e9), "is beyond 1e.06; is it in another unit"),
    "too fast to sample": (one_part("sine", amplitude=0.1, frequency=200, duration=1), "below half the sample rate"),
    "too fast to sum": (
        one_part("multisine", amplitude=0.1, frequencies="[125]", duration=1),
        "below half the sample rate, which is 125 Hz",
    ),
    "no sines": (one_part("multisine", amplitude=0.1, frequencies="[]", duration=1), "frequencies is empty"),
    "endless dwell": (one_part("triangle", amplitude=0.1, period=2, dwell=1e308), "The motion lasts inf s"),
    "limits beyond sense": ("[limits]\njerk = 1e300\n" + TO_START, "jerk = 1e.300 m/s.3 is out of range"),
    "joint limits beyond sense": ("[limits]\njoint_jerk = 1e-9\n" + TO_START, "must be in .1e-06"),
    "far away": (AT + LINE.format("9, 0, 0"), "job.toml: part 1 .line.: .*reach"),
    "sine after a move": (
        one_part("joints", to=0.1)
        + one_part("joints", to=0)
        + one_part("sine", amplitude=0.1, frequency=1, duration=1),
        "starts or ends at speed must be alone",
    ),
    "excitation elsewhere": (
        one_part("joints", to=0.1) + one_part("triangle", centre=0, amplitude=0.1, period=2),
        "Move there before",
    ),
}


@pytest.mark.parametrize(("text", "message"), BAD.values(), ids=BAD.keys())
def test_what_is_wrong_in_a_file_is_one_line_that_says_where(arm, text, message):
    with pytest.raises(FFGymError, match=message) as caught:
        motion(arm, text)
    assert "\n" not in str(caught.value).strip()


def test_named_points_need_a_work_area(one_axis):
    with pytest.raises(FFGymError, match="has no named points in its work area"):
        motion(RigidArm(one_axis), one_part("circle_test", speed=0.04))


def test_sliding_joints_have_no_degrees(ball_screw):
    with pytest.raises(FFGymError, match="to_deg is for hinges only"):
        motion(ball_screw, one_part("joints", to_deg=10))


@pytest.fixture(scope="module")
def ball_screw():
    from ffgym.robot import load_robot

    return RigidArm(load_robot("ball_screw"))


def test_every_entry_of_every_part_is_documented():
    for kind, part in PARTS.items():
        assert part.__doc__
        assert kind == part.kind
        for f in entries(part):
            assert f.metadata["meaning"]


def test_moves_of_the_same_program_are_the_same_motion(arm):
    from programs import line

    text = AT + TO_START + one_part("line", to="[0.1, 0, 0]", speed=0.1)
    np.testing.assert_array_equal(reference(arm, text).q, compose(arm, [line(0, 0, 0), line(0.1, 0, 0)]).reference.q)
