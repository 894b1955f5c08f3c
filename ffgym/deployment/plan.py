"""Set-points of one motion as a controller takes them: those of its program, and what a law adds to them."""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape, errors_at
from ffgym.core.files import decode_arrays, encode_arrays, read_bytes, write_bytes
from ffgym.core.typed_json import parse_json
from ffgym.core.types import Array
from ffgym.robot import RobotDescription

_FORMAT = "ffgym.plan 1"
"""Kind and version of the file."""
_HEADER = ("name", "robot", "law", "joints", "units", "dt", "meta")
_ARRAYS = ("program", "correction", "torque")


@dataclass(frozen=True, kw_only=True, eq=False)
class SetpointPlan:
    """Joint set-points of one motion, sampled evenly, with the correction that a feed-forward law adds to them.

    A controller knows its joints behind the gearbox, so all positions are link side: a set-point is where the motor
    is to be, divided by the gear ratio.
    """

    name: str
    """Name of the motion."""
    robot: str
    """Name of the robot."""
    law: str
    """Name of the feed-forward law that the correction stands for."""
    joints: tuple[str, ...]
    units: tuple[str, ...]
    """Unit of each joint position, rad or m."""
    dt: float
    """Time between samples [s]."""
    program: Array
    """Set-points of the program alone, link side [rad or m], shape (T, N)."""
    correction: Array
    """What is added to them, link side [rad or m], shape (T, N); zero at the first sample."""
    torque: Array
    """Feed-forward torque that the correction stands for, motor side [N m], shape (T, N), for controllers that take
    torques."""
    meta: Mapping[str, Any] = field(default_factory=dict)
    """Where the plan comes from: versions, fingerprints, limits that were met; JSON values."""

    def __post_init__(self) -> None:
        check_number("time between set-points", self.dt, unit="s", low=0.0, open_low=True)
        n = len(self.joints)
        check_shape("set-points of the program", self.program, (None, n))
        for name in ("correction", "torque"):
            check_shape(f"{name} of the plan", getattr(self, name), self.program.shape)
        if len(self.units) != n or not set(self.units) <= {"rad", "m"}:
            raise FFGymError(f"units = {self.units} must be 'rad' or 'm' for each of {n} joints.")
        if len(self.program) < 2:
            raise FFGymError(f"Plan {self.name!r} has {len(self.program)} samples, needs 2 or more.")

    @property
    def t(self) -> Array:
        """Times of the samples [s], shape (T,)."""
        return self.dt * np.arange(len(self.program), dtype=np.float64)

    @property
    def setpoints(self) -> Array:
        """Set-points with the correction, link side [rad or m], shape (T, N)."""
        return self.program + self.correction

    @property
    def largest_correction(self) -> Array:
        """Largest size of the correction of each joint, link side [rad or m], shape (N,)."""
        return np.asarray(np.abs(self.correction).max(axis=0), dtype=np.float64)


def numbers_per_unit(units: Sequence[str]) -> Array:
    """Return degrees for one rad, or millimetres for one m, as controllers write joint positions, shape (N,)."""
    return np.array([180 / np.pi if unit == "rad" else 1e3 for unit in units])


def check_fits(plan: SetpointPlan, robot: RobotDescription) -> None:
    """Check that a plan is for the joints of a robot.

    Raises:
        FFGymError: if it is not.
    """
    if plan.joints != robot.joints:
        raise FFGymError(
            f"Plan {plan.name!r} is for joints {', '.join(plan.joints)} of {plan.robot!r}, robot {robot.name!r} has "
            f"{', '.join(robot.joints)}. Name the robot of the plan."
        )


def write_plan(plan: SetpointPlan, path: str | os.PathLike[str]) -> None:
    """Write a plan as an .npz file, whole or not at all.

    Raises:
        FFGymError: if the file cannot be written.
    """
    header = {"format": _FORMAT} | {name: getattr(plan, name) for name in _HEADER}
    arrays = {name: getattr(plan, name) for name in _ARRAYS}
    write_bytes(path, encode_arrays({"header": np.array(json.dumps(header)), **arrays}))


def read_plan(path: str | os.PathLike[str]) -> SetpointPlan:
    """Read a plan that `write_plan` wrote.

    Raises:
        FFGymError: if the file cannot be read, or is no plan.
    """
    with errors_at(str(path)):
        arrays = decode_arrays(read_bytes(path))
        try:
            header = parse_json(str(arrays.pop("header")), "The header")
            if header.pop("format") != _FORMAT:
                raise KeyError("format")
            header |= {name: tuple(header[name]) for name in ("joints", "units")}
            return SetpointPlan(**header, **arrays)
        except (KeyError, TypeError, AttributeError) as error:
            raise FFGymError(
                f"The file is no plan of set-points of this version ({_FORMAT}): {error}. Plan the motion again."
            ) from error
