"""Programs of shops, written before the reader could run them, run unchanged: cutting, welding, handling and more."""

from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from ffgym.paths.motions.composition import rapid_motion
from ffgym.paths.moves import MoveArc, MoveJoint, MoveLinear, Pose, Wait
from ffgym.paths.rapid import load_program

FOLDER = Path(__file__).parent / "programs"
LASER = resources.files("ffgym.paths.rapid") / "examples" / "laser_plate.mod"

PROGRAMS = {
    # file: moves, lines, arcs, waits, texts of events
    "weld_frame.mod": (7, 4, 1, 0, ["ArcLStart: arc on", "ArcCEnd: arc off", 'TPWrite "Teile: "\\Num:=1']),
    "palletise.mod": (49, 30, 0, 6, ["Set doVacuum", "GripLoad ldBox", "SetDO doPalletFull, 1"]),
    "dispense.mod": (8, 7, 0, 0, ["SetAO aoFlow, 4.2", "SetDO doGun, 1", "SetDO doGun, 0", "InvertDO doCycle"]),
    "grind_blade.mod": (37, 36, 0, 0, ["SetAO aoBelt, 18.5", 'TPWrite "Strokes: 4"', "SetAO aoBelt, 0"]),
    "tend_lathe.mod": (10, 4, 0, 2, ["WaitDI diLatheReady, 1", "PulseDO doChuckClose\\PLength:=0.2"]),
    "borra_lada.mod": (39, 30, 0, 1, ["SetGO goVarvtal, 300", 'TPWrite "Antal hål: "\\Num:=8']),
    "exported_path.mod": (8, 4, 1, 0, ["SetDO do_process, 1", "SetDO do_process, 0"]),
    "deburr_lower.mod": (13, 12, 0, 0, ["setdo dospindle, 1", "setdo dospindle, 0"]),
    "milled_pocket.mod": (14, 10, 1, 1, ["SetGO goSpindle, 12000", "WaitDI diSpindleAtSpeed, 1"]),
    "old_gluing.prg": (24, 19, 0, 4, ["Set do1", "Reset do1", "EXIT"]),
    "cell/Cell.pgf": (16, 12, 0, 0, ["Set doCutter", "Reset doCutter"]),
}


@pytest.mark.parametrize("name", list(PROGRAMS))
def test_a_program_of_another_shop_runs_unchanged(irb4600, name):
    execution = load_program(FOLDER / name).execute(irb4600)
    counts = [sum(isinstance(m, kind) for m in execution.moves) for kind in (MoveLinear, MoveArc, Wait)]
    texts = [event.text for move in execution.moves for event in move.events]
    count, *kinds, told = PROGRAMS[name]
    assert [len(execution.moves), *counts] == [count, *kinds]
    assert [text for text in dict.fromkeys(texts) if text in told] == told


@pytest.mark.parametrize("name", ["dispense.mod", "cell/Cell.pgf", "exported_path.mod"])
def test_the_robot_can_make_it(arm, name):
    motion = rapid_motion(arm, FOLDER / name)
    kinematics = arm.robot.kinematics
    assert np.all(np.abs(motion.reference.dq) <= kinematics.max_speed)
    assert len(motion.events) >= 2


@pytest.mark.slow
@pytest.mark.parametrize("name", list(PROGRAMS))
def test_the_robot_can_make_all_of_them(arm, name):
    assert rapid_motion(arm, FOLDER / name).reference.duration > 5


def test_the_cutting_program_has_six_holes_and_a_slot_where_it_says(irb4600):
    """Radii 4 and 6 mm in a grid of 40 x 30 mm, ends of the slot of radius 4 mm, all in the frame of the plate."""
    with resources.as_file(LASER) as path:
        assert len(path.read_text(encoding="utf-8").splitlines()) >= 45
        execution = load_program(path).execute(irb4600)
    corner = np.array([1.25, -0.15, 0.602])
    tops = [m for m in execution.moves if isinstance(m, MoveJoint) and isinstance(m.to, Pose)]
    places = [((m.to.position - corner) * 1e3).round(6).tolist() for m in tops]
    holes = [[40 * column + 30, 30 * row + 25, 15] for row in range(2) for column in range(3)]
    assert places == [*holes, [30, 90, 15]]
    arcs = [m for m in execution.moves if isinstance(m, MoveArc)]
    ends = [((m.to.position - corner) * 1e3).round(6).tolist() for m in arcs]
    for i, (x, y, _) in enumerate(holes):
        radius = 4 if i < 3 else 6
        assert ends[2 * i : 2 * i + 2] == [[x - radius, y, 0], [x + radius, y, 0]]
    assert ends[12:] == [[110, 94, 0], [30, 86, 0]]
    cuts = {round(m.speed.tcp * 1e3, 6) for m in arcs}
    assert cuts == {35, 24.5}
    assert {m.speed.acceleration for m in arcs} == {0.6}


def test_the_laser_is_on_while_it_cuts_and_off_while_it_moves(arm):
    with resources.as_file(LASER) as path:
        motion = rapid_motion(arm, path)
    laser = [event for event in motion.events if "doLaser" in event.text]
    assert [event.text for event in laser] == ["SetDO doLaser, 1", "SetDO doLaser, 0"] * 7
    r = motion.reference
    tcp = arm.tcp_position(r.q)
    on = np.zeros(len(r.t), dtype=bool)
    for start, end in zip(laser[::2], laser[1::2], strict=True):
        on |= (r.t >= start.t) & (r.t <= end.t)
    assert np.all(np.abs(tcp[on, 2] - 0.602) < 1e-6)
    away = np.abs(tcp[:, 2] - 0.602) > 1e-3
    assert not np.any(on & away)
    assert np.sum(on) * r.t[1] > 8
    assert [note for note in motion.notes if "taken as 0" in note] == []
