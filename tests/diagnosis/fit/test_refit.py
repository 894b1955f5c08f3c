"""Numbers that were fitted to the logs are fitted anew beside causes: to the torque that the causes leave."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit import written as module
from ffgym.diagnosis.fit.written import _refit, _without_causes
from ffgym.effects import EFFECTS
from ffgym.recordings import Header, Recording

MEASURED = 10.0
"""Torque of all rows: 7 of the robot, and 3 of the cause."""


@dataclass(frozen=True)
class Numbers:
    """A machine whose torque is one number."""

    robot: float


class Toy:
    """A problem of two motions of two and three rows, of which the second is fitted to, and what is done with it."""

    def __init__(self, monkeypatch, impossible=()):
        self.nominal, self.impossible = Numbers(6.0), impossible
        self.log = SimpleNamespace(lengths=[2, 3])
        self.blocks = SimpleNamespace(motion=np.array([0, 1, 1]))
        self.replayed, self.moved, self.fitted = [], [], []
        monkeypatch.setattr(module, "replay_hypotheses", self.replay)
        monkeypatch.setattr(module, "_without_causes", self.take_off)
        monkeypatch.setattr(module, "_evidence", lambda problem, best: best)
        monkeypatch.setattr(module, "_solve", self.solve)
        monkeypatch.setattr(module, "move_hypotheses", lambda causes, steps: (causes[0] + float(steps[0]),))

    def replay(self, problem, causes, numbers):
        self.replayed.append((tuple(causes), numbers.robot))
        if len(self.replayed) in self.impossible:
            return None
        torque = np.full((3, 2, 1), numbers.robot + sum(causes))
        run, machine = SimpleNamespace(torque=torque), SimpleNamespace(effects=causes)
        return SimpleNamespace(run=run, machine=machine, numbers=numbers.robot, causes=tuple(causes))

    def take_off(self, problem, motion, effects, torque):
        assert len(torque) == self.log.lengths[motion]
        return motion, float(MEASURED - torque.mean())

    def solve(self, best, fit, sizes, chosen):
        np.testing.assert_array_equal(sizes, np.zeros(fit.n_nuisances))
        self.moved.append(best.causes)
        return np.array([0.0, 0.0, 3.0 - best.causes[0]])

    def fit(self, recordings):
        self.fitted.append([motion for motion, _ in recordings])
        return float(np.mean([torque for _, torque in recordings]))

    def refit(self, causes):
        fit = SimpleNamespace(hypotheses=causes, n_nuisances=2)
        return _refit(self, fit, self.fit, np.array([False, True, True]))


def test_numbers_and_causes_are_fitted_in_turn(monkeypatch):
    """The cause begins a unit too small, of which the numbers first take the rest."""
    toy = Toy(monkeypatch)
    found = toy.refit((2.0,))
    assert (found.numbers, found.causes) == (7.0, (3.0,))
    both = [((2.0,), 6.0), ((), 6.0), ((2.0,), 8.0)], [((3.0,), 8.0), ((), 8.0), ((3.0,), 7.0)]
    assert toy.replayed == [*both[0], *both[1]]
    assert toy.fitted == [[1], [1]]
    assert toy.moved == [(2.0,)]  # what suits the last numbers is not asked for


def test_without_causes_numbers_are_fitted_once(monkeypatch):
    toy = Toy(monkeypatch)
    found = toy.refit(())
    assert (found.numbers, found.causes) == (MEASURED, ())
    assert len(toy.fitted) == 1
    assert toy.moved == []


@pytest.mark.parametrize(
    ("impossible", "left"), [(1, None), (2, None), (3, None), (4, (8.0, (2.0,))), (5, (8.0, (2.0,))), (6, None)]
)
def test_where_no_machine_can_be_the_last_that_could_is_taken(monkeypatch, impossible, left):
    """Of the six replays of both rounds; the last of a round is of the model itself."""
    found = Toy(monkeypatch, (impossible,)).refit((2.0,))
    assert (found and (found.numbers, found.causes)) == left


@pytest.mark.parametrize("side", ["motor_side", "link_side"])
def test_a_recording_without_causes_has_its_torque_less_what_they_add(two_link, side):
    """On the side on which it was recorded, and at the instants of its positions."""
    t = 0.004 * np.arange(50)
    columns = {"timestamp": t}
    for k, joint in enumerate(two_link.joints, start=1):
        columns |= {f"motor.position.{joint}": np.sin(k * t), f"motor.effort.{joint}": np.cos(k * t)}
    ratio = tuple(two_link.drive.gear_ratio.tolist())
    header = Header(robot="two_link", joints=two_link.joints, gear_ratio=ratio, torque_semantics=side)
    recording = Recording(columns=columns, header=header)
    names = [f"motor.effort.{joint}" for joint in two_link.joints]
    measured = np.stack([recording[name] for name in names], axis=1)
    problem = SimpleNamespace(log=SimpleNamespace(recordings=[None, recording], robot=two_link))
    added = np.stack([np.linspace(0.0, 1.0, len(recording)), np.full(len(recording), -0.5)], axis=1)
    own = added if side == "motor_side" else two_link.drive.joint_torque(added)
    rest = _without_causes(problem, 1, (), added)
    np.testing.assert_allclose(np.stack([rest[name] for name in names], axis=1), measured - own)
    np.testing.assert_array_equal(rest["motor.position.shoulder"], recording["motor.position.shoulder"])
    late = EFFECTS["torque_clock"](latency=np.array(0.008))  # two rows
    earlier = _without_causes(problem, 1, (late,), added)
    shifted = np.stack([earlier[name] for name in names], axis=1)[5:-5]
    np.testing.assert_allclose(shifted, (measured[7:-3] - own[5:-5]), atol=1e-6 * np.abs(measured).max())
