"""Whether a cause is surely there, by the intervals of its sizes."""

import pytest

from ffgym.diagnosis.result import Cause, Size
from ffgym.diagnosis.sizes import is_there


def cause(effect, **intervals):
    sizes = tuple(
        Size(name=name.replace("_of_", "."), value=sum(ends) / 2, unit="", interval=ends)
        for name, ends in intervals.items()
    )
    return Cause(effect=effect, code="", title="", joint="j1", parameters=sizes, fixed={}, held_out_gain=1.0)


@pytest.mark.parametrize(
    ("found", "there"),
    [
        (cause("flexible_load", inertia=(0.0, 1e-3)), False),
        (cause("flexible_load", inertia=(1e-4, 1e-3)), True),
        (cause("joint_stiffness", change=(-0.1, 0.02)), False),
        (cause("joint_stiffness", change=(-0.1, -0.02)), True),
        (cause("tool_frame", offset_of_x=(-1e-5, 1e-5), offset_of_y=(1e-5, 2e-5)), True),
        (cause("cogging", amplitude=(0.0, 0.01), cycles=(11.9, 12.1)), False),
    ],
)
def test_a_cause_is_there_if_any_of_its_sizes_is_surely_not_nothing(found, there):
    assert is_there(found) == there
