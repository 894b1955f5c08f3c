"""What an arm file says about drives, as entries of a description."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from ffgym.core.types import Array
from ffgym.robot.arm_file import ArmFile, JointHints
from ffgym.robot.reading.rule import LINK
from ffgym.robot.template.proposals import Proposal

_HINTS: Mapping[str, tuple[Callable[[JointHints], float | None], str | None, str]] = {
    "kinematics.max_speed": (lambda hint: hint.speed, LINK, "speed limits"),
    "drive.gear_ratio": (lambda hint: hint.gear_ratio, None, "gear of transmission or actuator"),
    "drive.rotor_inertia": (
        lambda hint: hint.armature,
        LINK,
        "armature, the rotor at the joint; a simulator's number unless measured",
    ),
    "drive.peak_torque": (lambda hint: hint.effort, LINK, "effort or force limits"),
    "friction.coulomb": (lambda hint: hint.friction, LINK, "joint friction; a simulator's number unless measured"),
    "friction.viscous": (lambda hint: hint.damping, LINK, "joint damping; a simulator's number unless measured"),
}
"""Entry, the hint for a joint, the side it is on, and what it is in the file."""


def hinted(arm: ArmFile) -> dict[str, Proposal]:
    """Entries that the file hints at for some joints or all, by path; NaN stands for joints that it is silent about."""
    found = {}
    for path, (of, side, what) in _HINTS.items():
        value = _numbers([of(hint) for hint in arm.hints])
        if path not in arm.quantities and not np.all(np.isnan(value)):
            source = f"{Path(arm.path).name}: {what}"
            found[path] = Proposal(path=path, value=value, source=source, origin="sourced", side=side)
    return found


def _numbers(values: list[float | None]) -> Array:
    return np.array([np.nan if value is None else value for value in values])
