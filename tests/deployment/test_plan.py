"""Plans of set-points: what they hold, and their file."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.deployment import SetpointPlan, read_plan, write_plan


@pytest.fixture
def plan() -> SetpointPlan:
    """Plan of two joints and three samples."""
    program = np.array([[0.0, 1.0], [0.1, 1.1], [0.2, 1.2]])
    correction = np.array([[0.0, 0.0], [1e-4, -2e-4], [0.0, 1e-4]])
    return SetpointPlan(
        name="line",
        robot="two_axes",
        law="elastic",
        joints=("j1", "j2"),
        units=("rad", "m"),
        dt=0.004,
        program=program,
        correction=correction,
        torque=1e3 * correction,
        meta={"version": "1"},
    )


def test_a_plan_comes_back_from_its_file_with_every_bit(plan: SetpointPlan, tmp_path: Path) -> None:
    write_plan(plan, tmp_path / "plan.npz")
    back = read_plan(tmp_path / "plan.npz")
    for name in ("program", "correction", "torque"):
        assert np.array_equal(getattr(back, name), getattr(plan, name))
    for name in ("name", "robot", "law", "joints", "units", "dt", "meta"):
        assert getattr(back, name) == getattr(plan, name)


def test_setpoints_are_program_and_correction(plan: SetpointPlan) -> None:
    assert np.array_equal(plan.setpoints, plan.program + plan.correction)
    assert np.array_equal(plan.largest_correction, [1e-4, 2e-4])
    assert plan.t[-1] == 0.008


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"dt": 0.0}, "time between set-points = 0.0 s"),
        ({"correction": np.zeros((2, 2))}, "correction of the plan has shape"),
        ({"torque": np.full((3, 2), np.nan)}, "torque of the plan must be finite"),
        ({"units": ("rad", "deg")}, "must be 'rad' or 'm'"),
    ],
)
def test_a_plan_that_cannot_be_is_refused(plan: SetpointPlan, change: dict, message: str) -> None:
    with pytest.raises(FFGymError, match=message):
        replace(plan, **change)


def test_another_file_is_named_and_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "other.npz", header=np.array('{"format": "else"}'))
    with pytest.raises(FFGymError, match=r"other.npz: The file is no plan of set-points"):
        read_plan(tmp_path / "other.npz")
    (tmp_path / "text.npz").write_text("no archive")
    with pytest.raises(FFGymError, match=r"text.npz: Damaged"):
        read_plan(tmp_path / "text.npz")
