"""White noise of angles, up to that of 13 bits behind the gearbox, refuses no log."""

import numpy as np
import pytest

from ffgym.logs.quality import check_quality
from ffgym.logs.quality.wiring import find_wiring
from ffgym.robot import load_robot
from tests.logs.quality.wiring.wiring_samples import clean, noisy

COARSEST = 2 * np.pi / 2**13 / np.sqrt(12)
BEYOND = {"spike", "jump"}
"""Checks of single rows, which look at columns that have none of the noise."""


def refused(robot: str, dt: float, seed: int) -> list[str]:
    """Objections to the logs of a session with noise of a size by chance."""
    rng, described = np.random.default_rng(seed), load_robot(robot)
    size, derived = COARSEST * 10 ** rng.uniform(-2, 0), bool(rng.integers(2))
    logs = [noisy(log, size, rng, derived=derived) for log in clean(robot, dt)]
    found = [f for log in logs for f in check_quality(log, described, ("diagnosis",)).findings]
    said = [f.message for f in found if f.verdict == "refused" and f.check not in BEYOND]
    return said + [mistake.message for mistake in find_wiring(logs, described).mistakes]


@pytest.mark.parametrize(("robot", "dt"), [("one_axis", 0.002), ("two_link", 0.004)])
def test_a_noisy_log_is_not_refused(robot, dt):
    assert refused(robot, dt, 1) == []


@pytest.mark.slow
@pytest.mark.parametrize(("robot", "draws"), [("one_axis", 70), ("two_link", 70), ("irb4600_60_205", 60)])
def test_no_noisy_log_of_200_sessions_is_refused(robot, draws):
    said = {seed: refused(robot, (0.001, 0.002, 0.004)[seed % 3], seed) for seed in range(draws)}
    assert not any(said.values()), {seed: found for seed, found in said.items() if found}
