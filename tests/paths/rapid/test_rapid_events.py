"""What happens on the way beside moving is found in time and on the path of the tool."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rapid_samples import program

from ffgym.core.errors import FFGymError
from ffgym.paths.motions.composition import rapid_motion
from ffgym.paths.rapid import parse_program

DATA = "VAR triggdata a; VAR triggdata b; VAR triggdata l{2};"
TO = "Offs(p, 100, 0, 0)"


def motion_of(arm, tmp_path, body):
    path = tmp_path / "cut.mod"
    path.write_text(program(body, DATA))
    return rapid_motion(arm, path)


def passed(arm, motion, x):
    """Time at which the TCP is `x` [m] behind the first target."""
    tcp = arm.tcp_position(motion.reference.q)[:, 0] - 1.3
    return float(np.interp(x, tcp, motion.reference.t))


TRIGGERS = {
    "TriggIO a, 20\\DOp:=doA, 1;": (0.08, 0.0),
    "TriggIO a, 20\\Start\\DOp:=doA, 1;": (0.02, 0.0),
    "TriggIO a, 0\\DOp:=doA, 1;": (0.1, 0.0),
    "TriggIO a, 0.1\\Time\\DOp:=doA, 1;": (0.1, 0.1),
    "TriggIO a, 20\\DOp:=doA, 1\\DODelay:=0.05;": (0.08, -0.05),
    "TriggEquip a, 30, 0.05\\DOp:=doA, 1;": (0.07, 0.05),
}


@pytest.mark.parametrize("trigger", list(TRIGGERS))
def test_a_trigger_happens_at_its_distance_less_its_lag(arm, tmp_path, trigger):
    motion = motion_of(arm, tmp_path, trigger + f"TriggL {TO}, v50, a, fine, tRobot;")
    (event,) = motion.events
    x, lead = TRIGGERS[trigger]
    r = motion.reference
    end = next(p.end for p in r.phases if p.label == "Offs(p, 100, 0, 0)")
    at = passed(arm, motion, x) if x < 0.1 else end
    assert event.t == pytest.approx(at - lead, abs=r.t[1])
    assert event.text == "SetDO doA, 1"
    assert event.where.startswith("cut.mod:6:")
    if lead == 0:
        np.testing.assert_allclose(event.position, [1.3 + x, -0.2, 0.6], atol=2e-5)


@settings(max_examples=5, suppress_health_check=list(HealthCheck))
@given(st.lists(st.floats(0, 100).map(lambda x: round(x, 1)), min_size=2, max_size=4))
def test_triggers_follow_each_other_by_their_distance(arm, tmp_path, distances):
    names = [f"t{i}" for i in range(len(distances))]
    data = "".join(f"VAR triggdata {name}; " for name in names)
    body = "".join(
        f"TriggIO {name}, {d}\\DOp:=doA, {i};" for i, (name, d) in enumerate(zip(names, distances, strict=True))
    )
    options = "".join(f"\\T{i}:={name}" for i, name in enumerate(names[1:], start=2))
    path = tmp_path / "cut.mod"
    path.write_text(program(f"{body} TriggL {TO}, v50, t0{options}, fine, tRobot;", data))
    events = rapid_motion(arm, path).events
    assert [e.t for e in events] == sorted(e.t for e in events)
    away = [(1.4 - e.position[0]) * 1e3 for e in events]
    np.testing.assert_allclose(away, sorted(distances, reverse=True), atol=0.02)


def test_a_trigger_on_an_arc_and_in_joint_space_counts_along_the_path(arm, tmp_path):
    arc = "TriggC Offs(p, 10, 10, 0), Offs(p, 20, 0, 0), v20, a, fine, tRobot;"
    joint = "TriggJ Offs(p, 20, 0, 100), v50, b, fine, tRobot;"
    motion = motion_of(arm, tmp_path, "TriggIO a, 10\\DOp:=doA, 1; TriggIO b, 30\\DOp:=doB, 1;" + arc + joint)
    on_arc, in_joints = motion.events
    angle = 10 / 10  # 10 mm on a radius of 10 mm
    np.testing.assert_allclose(
        on_arc.position, [1.31 + 0.01 * np.cos(angle), -0.2 + 0.01 * np.sin(angle), 0.6], atol=2e-5
    )
    assert np.linalg.norm(in_joints.position - [1.32, -0.2, 0.7]) == pytest.approx(0.03, abs=1e-3)


def test_instructions_between_moves_happen_at_the_target_before_them(arm, tmp_path):
    body = f"SetDO do1, 1; MoveL {TO}, v50, z10, tRobot; SetDO do2, 1; WaitTime 0.5; SetDO do3, 1;"
    body += "MoveL Offs(p, 100, 50, 0), v50, fine, tRobot; SetDO do4, 1;"
    motion = motion_of(arm, tmp_path, body)
    assert [event.text for event in motion.events] == [f"SetDO do{i}, 1" for i in (1, 2, 3, 4)]
    times = [event.t for event in motion.events]
    assert times[2] - times[1] == pytest.approx(0.5, abs=motion.reference.t[1])
    tcp = [(event.position * 1e3).round(3).tolist() for event in motion.events]
    assert tcp == [[1300, -200, 600], [1400, -200, 600], [1400, -200, 600], [1400, -150, 600]]


def test_events_on_moves_that_go_nowhere_happen_where_the_robot_stands(arm, tmp_path):
    body = f"MoveL {TO}, v50, fine, tRobot; MoveL {TO}, v50, fine, tRobot; SetDO do1, 1; WaitTime 1;"
    motion = motion_of(arm, tmp_path, body)
    (event,) = motion.events
    np.testing.assert_allclose(event.position, [1.4, -0.2, 0.6], atol=1e-6)
    rest = next(p for p in motion.reference.phases if p.label == "wait 1 s")
    assert event.t == pytest.approx(rest.start, abs=motion.reference.t[1])


def test_in_a_rounded_corner_an_event_happens_at_its_middle(arm, tmp_path):
    body = f"MoveLDO {TO}, v50, z10, tRobot, do1, 1; MoveL Offs(p, 100, 50, 0), v50, fine, tRobot;"
    (event,) = motion_of(arm, tmp_path, body).events
    away = event.position - [1.4, -0.2, 0.6]
    assert 1e-3 < np.linalg.norm(away) < 1e-2
    assert away[0] == pytest.approx(-away[1], abs=1e-5)


def test_a_trigger_array_holds_several(arm, tmp_path):
    body = f"TriggIO l{{1}}, 50\\DOp:=doA, 1; TriggIO l{{2}}, 10\\AOp:=aoB, 2.5; TriggL {TO}, v50, l, fine, tRobot;"
    assert [e.text for e in motion_of(arm, tmp_path, body).events] == ["SetDO doA, 1", "SetAO aoB, 2.5"]


def test_a_trigger_that_is_not_set_is_one_error(irb4600):
    text = program(f"TriggL {TO}, v50, a, fine, tRobot;", DATA)
    with pytest.raises(FFGymError, match=r"^cut.mod:6:1: a is not set; define it by TriggIO or TriggEquip before"):
        parse_program(text, "cut.mod").execute(irb4600)
    text = program("TriggIO a, -5\\DOp:=doA, 1;", DATA)
    with pytest.raises(FFGymError, match=r"^cut.mod:6:1: the distance of TriggIO is -5, must be >= 0"):
        parse_program(text, "cut.mod").execute(irb4600)
