"""Loops without end, inputs, waits and settings: what a production program becomes."""

import numpy as np
import pytest
from rapid_samples import moves_of, program

from ffgym.core.errors import FFGymError
from ffgym.paths.motions.composition import rapid_motion
from ffgym.paths.rapid import parse_program

GO = "MoveL Offs(p, {}, 0, 0), {}, {}, tRobot;"


def run(robot, body, data="VAR num x := 0;", more="", **how):
    """Execution of statements, without the first move."""
    return parse_program(program(body, data, more), "cut.mod").execute(robot, **how)


ENDLESS = {
    "WHILE TRUE DO WaitTime 1; ENDWHILE WaitTime 9;": 1,
    "WHILE TRUE DO x := x + 1; WaitTime 1; ENDWHILE": 1,
    "WHILE diRun = 1 DO x := x + 1; WaitTime 1; ENDWHILE": 1,
    "again: WaitTime 1; x := x + 1; GOTO again;": 1,
    "WHILE TRUE DO WaitTime 1; IF diStop = 1 RETURN; ENDWHILE": 1,
    "WHILE x = 0 DO WaitTime 1; ENDWHILE": 1,
}


@pytest.mark.parametrize("body", list(ENDLESS))
def test_a_loop_without_end_is_run_once_or_as_often_as_asked_and_noted(irb4600, body):
    for cycles in (1, 3):
        done = run(irb4600, body, inputs={"diRun": 1}, cycles=cycles)
        assert [move.duration for move in done.moves[1:]] == [1] * cycles
        times = "once" if cycles == 1 else "3 times"
        assert any(f"a loop without end, run {times} (cycles)" in note for note in done.notes)


def test_a_loop_that_may_be_left_is_run_until_it_is(irb4600):
    body = "WHILE TRUE DO x := x + 1; WaitTime x; IF x = 4 GOTO done; ENDWHILE done: WaitTime 9;"
    done = run(irb4600, body)
    assert [move.duration for move in done.moves[1:]] == [1, 2, 3, 4, 9]
    assert done.notes == ()


def test_a_loop_by_goto_begins_anew_in_every_call_of_its_routine(irb4600):
    twice = "PROC twice() VAR num n := 0; again: n := n + 1; WaitTime n; IF n < 2 GOTO again; ENDPROC"
    done = run(irb4600, "twice; twice; twice;", more=twice)
    assert [move.duration for move in done.moves[1:]] == [1, 2] * 3
    assert done.notes == ()


def test_a_loop_that_only_waits_for_an_input_is_left_with_a_note(irb4600):
    done = run(irb4600, 'WHILE DInput(diOk) = 0 DO TPWrite "wait"; ENDWHILE WaitTime 2;')
    assert [move.duration for move in done.moves[1:]] == [2]
    assert done.notes[0] == "cut.mod:6:1: a loop that waits for an input, left after one pass"


def test_inputs_have_the_values_that_are_given_and_are_noted_where_they_are_not(irb4600):
    body = "IF diA = 1 WaitTime 1; IF TestDI(diB) WaitTime 2; IF GInput(giC) = 5 WaitTime 3;"
    done = run(irb4600, body)
    assert len(done.moves) == 1
    assert done.notes == ("taken as 0, because no value was given (inputs): diA, diB, giC",)
    done = run(irb4600, body, inputs={"DIA": True, "diB": 1, "giC": 5})
    assert [move.duration for move in done.moves[1:]] == [1, 2, 3]
    assert done.notes == ()
    with pytest.raises(FFGymError, match="input diA must be a number"):
        run(irb4600, body, inputs={"diA": "high"})
    with pytest.raises(FFGymError, match=r"cycles = 0.0 is out of range, must be in \[1, 1000\]"):
        run(irb4600, body, cycles=0)


@pytest.mark.parametrize(
    "wait", ["WaitDI diA, 1;", "WaitUntil diA = 1 AND x = 0;", "WaitUntil DInput(diA)=1\\MaxTime:=2;"]
)
def test_what_a_program_has_waited_for_is_known_from_there_on(irb4600, wait):
    done = run(irb4600, f"{wait} IF diA = 1 WaitTime 1;")
    assert len(done.moves) == 2
    assert done.notes == ()
    assert done.moves[0].events[0].text == wait.rstrip(";")


def test_outputs_are_what_the_program_has_set(irb4600):
    body = (
        "SetDO doA, 1; InvertDO doB; Reset doC; SetGO goD, 7; WaitTime 1 + DOutput(doA) + DOutput(doB) + DOutput(doC);"
    )
    body += "WaitTime 1 + DOutput(doC); WaitTime GOutput(goD);"
    more = "PROC go() WaitDI di1, 1\\MaxTime:=1\\TimeFlag:=b; IF NOT b WaitTime 5; ENDPROC"
    done = run(irb4600, body + "go;", "VAR bool b := TRUE;", more)
    assert [move.duration for move in done.moves[1:]] == [3, 1, 7, 5]
    assert done.notes == ()


def test_a_program_that_comes_to_an_error_of_its_own_is_refused(irb4600):
    with pytest.raises(FFGymError, match=r"^cut.mod:6:12: the program comes to RAISE"):
        run(irb4600, "IF di1 = 0 RAISE;")


def test_vel_set_scales_and_bounds_the_speeds_that_follow(irb4600):
    body = GO.format(1, "v100", "fine") + "VelSet 50, 30;" + GO.format(2, "v100", "fine") + GO.format(3, "v20", "fine")
    found = [(round(m.speed.tcp, 9), round(np.rad2deg(m.speed.turn), 6)) for m in moves_of(irb4600, body)]
    assert found == [(0.1, 500), (0.03, 250), (0.01, 250)]


def test_acc_set_makes_a_motion_gentler(arm, tmp_path):
    path = tmp_path / "cut.mod"
    peaks = []
    for setting in ("AccSet 100, 100;", "AccSet 50, 100;", "AccSet 5, 100;"):
        path.write_text(program(setting + GO.format(100, "v500", "fine")))
        r = rapid_motion(arm, path).reference
        speed = np.linalg.norm(np.einsum("tij,tj->ti", arm.jacobian(r.q), r.dq)[:, :3], axis=1)
        peaks.append(np.abs(np.diff(speed)).max() / r.t[1])
    np.testing.assert_allclose(peaks, [2.0, 1.0, 0.4], rtol=0.03)


def test_acc_set_cuts_what_it_is_given_as_the_controller_does(irb4600):
    shares_of = {"AccSet 60, 50;": (0.6, 0.3), "AccSet 5, 5;": (0.2, 0.02), "AccSet 150, 150;": (1.0, 1.0)}
    for setting, shares in shares_of.items():
        speed = run(irb4600, setting + GO.format(10, "v10", "fine")).moves[1].speed
        assert (speed.acceleration, speed.jerk) == pytest.approx(shares)


def test_a_wait_behind_a_zone_stops_the_robot_with_a_note(irb4600):
    done = run(irb4600, GO.format(10, "v10", "z5") + "WaitTime 1;")
    assert done.moves[1].zone.stops
    assert done.notes == ("cut.mod:6:42: the robot stops at 'Offs(p, 10, 0, 0)' for WaitTime, in spite of its zone",)


def test_a_first_move_on_a_line_starts_at_its_target_with_a_note(arm, tmp_path):
    path = tmp_path / "cut.mod"
    path.write_text(program("").replace("MoveJ p", "MoveL p"))
    motion = rapid_motion(arm, path)
    assert motion.notes == ("cut.mod:5:1: the first move is MoveL; the motion starts at its target",)
    np.testing.assert_allclose(arm.tcp_position(motion.reference.q[:1])[0], [1.3, -0.2, 0.6], atol=1e-9)


def test_joint_moves_of_the_bare_flange_lead_where_its_pose_says(irb4600):
    """The TCP of tRobot stands where the flange brings it, at 100 mm along x and 273.2 mm along z of tool0."""
    home = "MoveJ [[1200, 0, 1000], [0, 0, 1, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]], v100, fine, tool0;"
    (move,) = moves_of(irb4600, home)
    np.testing.assert_allclose(move.to.position, [1.1, 0, 1.0 - 0.2732], atol=1e-9)
