"""What each effect changes in a replay is what it leaves of a log in which it truly acted, to first order."""

from functools import cache

import numpy as np
import pytest

from ffgym.core.measures import rms
from ffgym.diagnosis.fit.problem import compute_exchange_changes
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.replay import replay
from ffgym.diagnosis.residual_rows import filter_measured, find_valid_rows
from ffgym.effects import EFFECTS, ModelEffect
from tests.diagnosis.replay.replay_samples import left, nominal, recorded, small, with_effect

QUICK = ("coulomb_level", "load_friction", "backlash", "payload", "torque_clock")
"""One for each way into a simulation: description, torque before and behind the gearbox, masses, clock."""
NOT_IN_A_REPLAY = {kind.name for kind in EFFECTS.values() if issubclass(kind, ModelEffect)}
"""They take joints that a replay does not have, and are listed as not judgeable."""
TRIED = [name for name in EFFECTS if name not in NOT_IN_A_REPLAY]

SHOWS = 1e-6
"""Share of a signal below which a change of it is that of floating point and steps of time."""

SHARE = 0.1
"""Of what is plausible, for most effects."""
SHARES = {"hardening": 0.002, "payload": 0.01, "joint_stiffness": 0.01, "backlash": 0.02, "torsional_hysteresis": 0.02}
"""Effects that change how the arm swings, or act in a gap, bend sooner."""
ALIKE = 0.95
LESS_ALIKE = {"stribeck_exponent": 0.9}
"""It acts for some milliseconds of each reversal, which samples 2 ms apart hardly resolve."""


@cache
def log_with(name):
    """Recordings of the nominal machine and of one with an effect."""
    effect = small(EFFECTS[name], nominal().robot, SHARES.get(name, SHARE))
    machine = with_effect(effect)
    return machine, recorded({"nominal": nominal(), name: machine})


def as_compared(channel, rows):
    """Rows without what the comparison takes off."""
    return rows - rows.mean(axis=0) if channel in ("link", "servo") else rows


@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in TRIED]
)
def test_a_small_effect_changes_a_replay_as_it_changes_the_machine(name):
    machine, recordings = log_with(name)
    _, rest = left(list(recordings.values()), nominal())
    own = assemble_log(nominal().robot, [recordings["nominal"]])
    (parts,) = compute_exchange_changes(replay(own, nominal()), [machine])
    inside, measured = find_valid_rows(own)[:, 0], filter_measured(own)
    shown = set()
    for channel, rows in rest.items():
        true = as_compared(channel, (rows[:, 1] - rows[:, 0])[inside])
        none = np.zeros((len(inside), 1))
        change = np.stack([parts.get((channel, c), none)[inside, 0] for c in range(rows.shape[2])], axis=1)
        expected = as_compared(channel, change)
        if rms(expected) < SHOWS * rms(measured[channel][inside]):
            continue
        shown.add(channel)
        assert np.sum(true * expected) / (true.size * rms(true) * rms(expected)) > LESS_ALIKE.get(name, ALIKE), channel
        assert rms(expected) == pytest.approx(rms(true), rel=0.15), channel
    assert shown


@pytest.mark.parametrize("name", ["load_friction", "backlash", "payload"])
def test_a_replay_of_the_machine_with_the_effect_leaves_little_of_it(name):
    machine, recordings = log_with(name)
    log, nothing_known = left([recordings[name]], nominal())
    _, known = left([recordings[name]], machine)
    _, bias = left([recordings["nominal"]], nominal())
    inside = find_valid_rows(log)
    effect = (nothing_known["torque"] - bias["torque"])[inside]
    rest = (known["torque"] - bias["torque"])[inside]
    assert np.sqrt(np.mean(rest**2)) < 0.2 * np.sqrt(np.mean(effect**2))
