"""Questions of the second exam: drawn by seed, of all machines and logs, with effects that are there and heard."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.effects import EFFECTS
from scripts.exam.independent import question, setup
from scripts.exam.independent.hidden import KINDS, conceal, possible
from scripts.exam.independent.loudness import loudness
from scripts.exam.independent.machine import numbers_of
from scripts.exam.independent.motions import KINDS as MOTIONS
from scripts.exam.independent.motions import motion
from scripts.exam.independent.question import _beside, draw_task
from scripts.exam.independent.robots import draw_robot
from scripts.exam.independent.sensors import Columns, View, _drawn
from scripts.exam.independent.setup import CONTROLS, EARLY, draw_setup, simulate_machines

ALL = Columns(tracker=True, set_points=True, feedback=True, speed=True, temperature=True)
SHORT = {"count": 1, "duration": 1.0}


@pytest.fixture(autouse=True)
def coarse_steps(monkeypatch):
    """Twice the step of the exam, which is fine enough for these questions."""
    monkeypatch.setattr(setup, "STEP", 0.001)


@pytest.fixture
def rng():
    return np.random.default_rng(5)


def setup_of(rng, **more):
    known = {"n": 1, "elastic": True, "control": "documented", "columns": ALL, "noise": "white", "row_dt": 0.005}
    return draw_setup(rng, **(known | SHORT | more))


def test_a_question_depends_on_nothing_but_its_number_and_the_seed():
    one, same = (draw_task("clean", 3, seed=1, n=1, **SHORT) for _ in range(2))
    other = draw_task("clean", 4, seed=1, n=1, **SHORT)
    assert one.setup.label == same.setup.label
    for a, b in zip(one.log, same.log, strict=True):
        assert all(np.array_equal(a[name], b[name], equal_nan=True) for name in a.columns)
    assert not np.array_equal(one.log[0]["motor.effort.a1"][:50], other.log[0]["motor.effort.a1"][:50])


def test_machines_and_logs_are_of_all_kinds(rng):
    drawn = [draw_setup(rng, count=1, duration=0.7) for _ in range(80)]
    assert {machine.robot.n_joints for machine in drawn} == {1, 2, 3, 4, 6, 7}
    assert {machine.robot.drive.is_rigid.all() for machine in drawn} == {True, False}
    assert {machine.control for machine in drawn} == set(CONTROLS)
    assert {machine.row_dt for machine in drawn} == {0.001, 0.002, 0.004, 0.005, 0.008, 0.01}
    assert any((machine.robot.drive.gear_ratio < 0).any() for machine in drawn)
    for name in ("tracker", "set_points", "feedback", "speed", "temperature"):
        assert {getattr(machine.columns, name) for machine in drawn} == {True, False}
    assert {machine.share for machine in drawn} == {0.005, 0.05}
    assert {machine.robot.work_area is None for machine in drawn} == {True, False}


@pytest.mark.parametrize("kind", MOTIONS)
def test_motions_stay_within_reach_and_speed_and_begin_and_end_at_rest(kind, rng):
    home, reach, speed = np.array([0.2, -0.3]), np.array([0.5, 0.4]), np.array([2.0, 1.5])
    for _ in range(5):
        q, dq, ddq = motion(kind, home, reach, speed, 4.0, 0.00025, rng)
        assert np.all(np.abs(q - home) <= 1.6 * reach)
        assert np.all(np.abs(dq) <= 1.2 * speed)
        np.testing.assert_allclose(q[[0, -1]], np.tile(home, (2, 1)), atol=1e-9)
        assert np.ptp(q, axis=0).min() > 0.003
        assert np.abs(ddq).max() < 400
        np.testing.assert_allclose(np.cumsum(dq, axis=0) * 0.00025 + q[0], q, atol=2e-3)


def test_set_points_of_an_early_log_lead_by_what_it_says(rng):
    machine = setup_of(rng, control="early", elastic=False)
    (exact,) = simulate_machines(machine, [(machine.numbers, machine.view)])
    rows = round(EARLY / machine.row_dt)
    late = np.abs(exact.set_point[:-rows] - exact.angle[rows:]).max()
    assert late < 0.1 * np.abs(exact.set_point - exact.angle).max()


def test_machines_side_by_side_do_as_alone(rng):
    machine = setup_of(rng)
    other = numbers_of(machine.robot)
    _, beside = simulate_machines(machine, [(machine.numbers, machine.view), (other, View())])
    (alone,) = simulate_machines(machine, [(other, View())])
    np.testing.assert_allclose(beside.torque, alone.torque, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(beside.tool, alone.tool, atol=1e-12)


def test_each_effect_changes_the_log_and_has_a_name_in_the_library_or_a_clue(rng):
    machine = setup_of(rng, n=2, count=1)
    all_hidden = [conceal(name, machine.robot, rng) for name in KINDS]
    plain = (machine.numbers, machine.view)
    without, *others = simulate_machines(machine, [plain, *(hidden.on(plain) for hidden in all_hidden)])
    scale = machine.robot.friction.coulomb
    for hidden, exact in zip(all_hidden, others, strict=True):
        torque = np.abs((exact.torque - without.torque) / scale).max()
        assert torque > 1e-3 or np.abs(exact.tool - without.tool).max() > 1e-5, hidden.name
        if hidden.answer:
            known = EFFECTS[hidden.answer].parameters()
            assert {number.partition(".")[0] for number in hidden.numbers(machine.robot)} <= set(known)
            assert hidden.clue(machine.robot) is None
        else:
            assert hidden.clue(machine.robot) is not None


def test_effects_that_a_machine_cannot_have_are_not_hidden(rng):
    rigid = draw_robot(1, elastic=False, rng=rng)
    shown = possible(rigid, replace(ALL, tracker=False, temperature=False))
    assert not {"gap", "stiffness", "latency", "warm", "neighbour"} & set(shown)
    assert {"coulomb", "brake"} <= set(shown)


def test_an_error_of_the_description_is_not_loud():
    quiet = draw_task("single", 0, seed=2, n=1, elastic=False, noise="white", share=0.05, **SHORT)
    assert quiet.truth[0].loudness >= 1.0


@pytest.mark.parametrize(("share", "is_loud"), [(0.005, True), (0.05, False)])
def test_a_number_within_its_calibration_is_not_loud_where_another_effect_is(share, is_loud, rng):
    """Coulomb friction that is a tenth higher, of a machine whose numbers are known to 0.5 % or to 5 %."""
    machine = setup_of(rng, n=1, count=2, elastic=False, share=share, noise="quiet")
    hidden = replace(conceal("coulomb", machine.robot, rng), size=0.1)
    assert hidden.kind.of_number
    plain = (machine.numbers, machine.view)
    without, exact = simulate_machines(machine, [plain, hidden.on(plain)])
    assert (loudness(machine, without, exact, error=hidden.size) > 10) == is_loud
    assert loudness(machine, without, exact) > 10


@pytest.mark.parametrize("name", ["coulomb", "viscous", "presliding", "stiffness", "rotor"])
def test_the_true_size_of_a_number_is_by_how_much_the_machine_differs_from_its_description(name, rng):
    """By the effect and by the error of the description, which nobody can tell apart."""
    machine = setup_of(rng, share=0.05)
    alone = conceal(name, machine.robot, rng)
    hidden = replace(alone, beside=_beside(alone, machine))
    true = hidden.on((machine.numbers, machine.view))[0]
    off = getattr(true, name)[0, 0] / getattr(numbers_of(machine.robot), name)[0, 0] - 1
    assert max(hidden.numbers(machine.robot).values(), key=abs) == pytest.approx(off)
    assert abs(off - hidden.size) > 1e-4


@pytest.mark.parametrize(("noise", "memory"), [("white", 0.0), ("coloured", np.exp(-0.002 / 0.006))])
def test_noise_has_unit_size_and_the_memory_that_it_is_said_to_have(noise, memory, rng):
    values = _drawn((20000, 1), noise, 0.002, rng)[:, 0]
    assert np.std(values) == pytest.approx(1.0, abs=0.03)
    assert np.corrcoef(values[1:], values[:-1])[0, 1] == pytest.approx(memory, abs=0.03)


def test_an_effect_with_which_a_machine_does_not_hold_is_drawn_anew(monkeypatch):
    """A lag of the torque as long as the delays of its loop made a question end the exam."""
    drawn, held = [], setup.simulate_machines

    def unstable_at_first(machine, machines):
        drawn.append(machines)
        if len(drawn) < 3:
            raise FFGymError("The independent plant became unstable.")
        return held(machine, machines)

    monkeypatch.setattr(question, "simulate_machines", unstable_at_first)
    task = draw_task("single", 3, seed=1, n=1, **SHORT)
    assert len(drawn) == 3
    assert len(task.truth) == 1
    drawn.clear()
    with pytest.raises(FFGymError, match="unstable"):
        question._draw_stable(task.truth[0].effect, task.setup, np.random.default_rng(0), 2)
