"""What an agent decides beside others it decides alone too, and in time."""

import numpy as np
import pytest

from ffgym.leaderboard.submission import pack as packing
from ffgym.leaderboard.submission.alone import _check_time
from ffgym.leaderboard.submission.refusal import Refused
from tests.leaderboard.submission_samples import SIDE_BY_SIDE, agent_file, packed, verifier

LOOKS_ASIDE = agent_file("action = action + 0.05 * action[:1]")
"""Its first row does not depend on others; its second does."""


def test_an_agent_that_acts_on_what_another_robot_sees_is_not_packed():
    with pytest.raises(Refused, match="nominal, motion 1 alone it does not decide what was logged"):
        packed(content=LOOKS_ASIDE, plan=SIDE_BY_SIDE)


def test_an_agent_that_acts_on_what_another_robot_sees_is_refused_though_it_was_packed(monkeypatch):
    monkeypatch.setattr(packing, "check_alone", lambda *arguments: 1.0)
    data = packed(content=LOOKS_ASIDE, plan=SIDE_BY_SIDE).data
    with pytest.raises(Refused, match="nominal, motion 1 alone it does not decide what was logged") as caught:
        verifier(SIDE_BY_SIDE).verify(data)
    assert caught.value.check == "agent"


def test_an_agent_that_keeps_its_memory_in_itself_is_packed_and_accepted():
    body = "self.past = 0.5 * getattr(self, 'past', 0 * action) + action\naction = 0.5 * self.past"
    data = packed(content=agent_file(body), plan=SIDE_BY_SIDE).data
    assert verifier(SIDE_BY_SIDE).verify(data).action_difference == 0.0


@pytest.mark.parametrize(("times", "which"), [([4500.0] * 10, "median"), ([10.0] * 99 + [1e6], "mean")])
def test_decisions_that_take_longer_than_a_control_step_are_refused(times, which):
    with pytest.raises(Refused, match=f"must take at most 4000 us .{which} of"):
        _check_time(times, 0.004)


def test_the_first_decision_may_take_long():
    _check_time([*np.full(1, 1e6), *np.full(99, 10.0)], 0.004)
