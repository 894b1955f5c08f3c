"""What an exchange of machines changes is what their replays differ by, to first order."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.fit import problem as module
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.problem import _nudge, compute_exchange_changes, compute_tangents
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.replay.channels import predict
from ffgym.diagnosis.replay.rows import replay
from ffgym.diagnosis.residual_rows import find_valid_rows
from ffgym.effects import EFFECTS
from tests.diagnosis.replay.replay_samples import nominal, recorded, small, with_effect

FIRST_ORDER = ("coulomb_level", "load_friction", "kinematic_error", "resolver_ripple", "base_flexibility", "link_clock")
"""One for each way into a replay: description, torques before and behind the gearbox, reading, joints, clock."""
BESIDE = ("tool_frame", "torque_clock", "servo_gains")


@pytest.fixture(scope="module")
def log():
    """Torque, places of tool and links, and feedback of the servo."""
    found = assemble_log(nominal().robot, list(recorded({"nominal": nominal()}).values()))
    assert found.tool is not None
    assert found.link is not None
    assert found.shows_servo
    return found


def effect(name, share=0.05):
    return small(EFFECTS[name], nominal().robot, share)


def check(log, before, machines, within=0.02):
    """Compare changes by machines with differences of replays; return the channels of which each changes something."""
    run, inside, shown = replay(log, before), find_valid_rows(log), []
    now = predict(run)
    for machine, parts in zip(machines, compute_exchange_changes(run, machines), strict=True):
        shown.append(set())
        then = predict(replay(log, machine))
        for channel, rows in now.items():
            for c in range(rows.shape[2]):
                wanted = (then[channel] - rows)[inside][:, c]
                change = np.broadcast_to(parts.get((channel, c), 0.0), inside.shape)[inside]
                largest = np.abs(wanted).max()
                np.testing.assert_allclose(change, wanted, rtol=0, atol=within * largest + 1e-9)
                if largest > 1e-9:
                    shown[-1].add(channel)
    return shown


def test_machines_that_come_together_each_change_a_replay_by_their_own(log):
    shown = check(log, nominal(), [with_effect(effect(name)) for name in (*FIRST_ORDER, *BESIDE)])
    springs = {"torque", "tool", "link"}
    assert shown == [{"torque"}, {"torque"}, springs, springs, springs, {"link"}, {"tool"}, {"torque"}, {"servo"}]


def test_effects_that_go_and_that_come_change_a_replay_together(log):
    kept, friction = effect("cogging"), effect("load_friction")
    before = with_effect(effect("kinematic_error"), kept, effect("tool_frame"), friction, effect("servo_gains"))
    after = with_effect(kept, effect("tool_frame", -0.02), effect("link_clock"), effect("coulomb_level"))
    (shown,) = check(log, before, [after])
    assert shown == {"torque", "tool", "link", "servo"}


def test_only_channels_that_a_log_has_are_changed(log):
    """A servo that stays as it is changes nothing."""
    poor = log.torque_alone
    machines = [with_effect(effect(name)) for name in (*BESIDE, "load_friction")]
    for parts in compute_exchange_changes(replay(poor, nominal()), machines):
        assert {channel for channel, _ in parts} == {"torque"}
    (parts,) = compute_exchange_changes(replay(log, nominal()), machines[-1:])
    assert {channel for channel, _ in parts} == {"torque", "link", "tool"}


def test_a_machine_in_place_of_itself_changes_nothing(log):
    run = replay(log, with_effect(effect("load_friction")))
    (parts,) = compute_exchange_changes(run, [run.machine])
    assert not any(np.any(rows) for rows in parts.values())


def cause(name, joint, **values):
    return Hypothesis(kind=EFFECTS[name], joint=joint, source=None, values={k: np.array(v) for k, v in values.items()})


def test_a_number_is_nudged_up_or_down_where_it_is_at_its_bound():
    joint, beside = nominal().robot.joints[0], effect("cogging")
    drift = cause("viscous_drift", joint, share=0.2, duration=600.0, exponent=1.0)
    at_bound = drift.move([0.0, 1e9, 0.0])
    for one, up in ((drift, True), (at_bound, False)):
        free = one.list_free()[1]
        machine, step = _nudge(with_effect(beside, one.effect(nominal().robot)), 1, one, 1)
        nudge = free.nudge if up else -free.nudge
        assert machine.effects[0] is beside
        assert float(machine.effects[1].duration[0]) == pytest.approx(free.value + nudge)
        assert float(machine.effects[1].share[0]) == 0.2
        assert step == pytest.approx(nudge / free.step)
        assert (free.value == free.high) is not up


@pytest.mark.parametrize(("high", "change"), [(1.5, 0.5), (1.25, -0.5)])
def test_a_number_is_nudged_up_to_its_bound_but_not_beyond(monkeypatch, high, change):
    number = SimpleNamespace(name="share", value=1.0, nudge=0.5, step=2.0, low=0.5, high=high)
    moved = []
    one = SimpleNamespace(
        list_free=lambda: [number], move=lambda by: moved.append(by) or SimpleNamespace(effect=lambda robot: "effect")
    )
    monkeypatch.setattr(module, "exchange_effects", lambda machine, effects: effects)
    machine = SimpleNamespace(effects=("beside", "before"), robot=None)
    assert _nudge(machine, 1, one, 0) == (["beside", "effect"], change / 2.0)
    assert moved == [[change]]


def test_a_number_that_can_be_neither_higher_nor_lower_is_told(monkeypatch):
    one = cause("load_friction", nominal().robot.joints[0], share=0.1)
    monkeypatch.setattr(module, "exchange_effects", lambda machine, effects: None)
    with pytest.raises(FFGymError, match=r"share of load_friction on .* = 0\.1 can be neither higher nor lower"):
        _nudge(one.on(nominal()), 0, one, 0)


def test_tangents_are_per_practical_step_of_a_machine_with_effects_before(log):
    """Load friction is as its share, whatever beside it."""
    one = cause("load_friction", nominal().robot.joints[1], share=0.1)
    before = with_effect(effect("cogging"))
    run = replay(log, one.on(before))
    (column,) = compute_tangents(run, before, [one])
    none = predict(replay(log, before))["torque"]
    inside, step = find_valid_rows(log), one.list_free()[0].step
    wanted = (predict(run)["torque"] - none)[inside][:, 1] * step / 0.1
    np.testing.assert_allclose(column["torque", 1][inside], wanted, rtol=0, atol=1e-6 * np.abs(wanted).max())
    assert compute_tangents(run, before, [one], {0: [column]}) == [column]
    both = [one, cause("viscous_level", nominal().robot.joints[0], change=0.1)]
    beside = replay(log, both[1].on(run.machine))
    known = compute_tangents(beside, before, both)
    again = compute_tangents(beside, before, both, {0: [column]})
    assert again[0] is column
    assert len(again) == len(known) == 2
    for key, values in known[1].items():
        np.testing.assert_allclose(again[1][key], values, rtol=1e-9, atol=1e-9 * np.abs(values).max())
