"""Check of a robot description: entries that it lacks, functions that work, and computed properties."""

from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.robot import CAPABILITIES, Capability, RigidArm, RobotDescription, RobotDraft, resonances
from ffgym.studies.robot_check.doubts import list_doubts
from ffgym.studies.robot_check.loads import (
    Gravity,
    Inertia,
    Margin,
    ServoLoop,
    compute_gravity,
    compute_inertia,
    compute_margin,
    servo_loop,
)
from ffgym.studies.robot_check.shape import CheckedPose, Reach, compute_reach, rest_place, solve_poses

_SMALL_MARGIN = 2.0
"""Gain margin below which a servo counts as tight; the rule of thumb of 6 dB."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Resonances:
    """Undamped resonances in one pose [Hz], ascending; rigid joints have none."""

    locked: Array
    """Resonances with motors held."""
    free: Array | None
    """Resonances with motors free; None if gear ratios or rotors are not known."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RobotCheck:
    """Result of a check; a part for which the description lacks numbers is None."""

    draft: RobotDraft
    lacks: dict[str, tuple[str, ...]]
    """Entries that each capability lacks, by its name; empty where it works."""
    reach: Reach | None
    rest: CheckedPose | None
    """Rest pose: home of the work area, or the joints nearest to 0."""
    places: tuple[CheckedPose, ...]
    """Positions of the work area; without one, the rest pose."""
    mass: float | None
    """Mass of all links and the tool [kg], without the base."""
    resonances: dict[str, Resonances] | None
    """Resonances by the name of the pose."""
    gravity: Gravity | None
    inertia: Inertia | None
    margin: Margin | None
    servo: ServoLoop | None
    doubts: tuple[str, ...]

    def works(self, capability: Capability) -> bool:
        """Check that a function works with this description."""
        return not self.lacks[capability.name]

    def numbers(self) -> dict[str, Any]:
        """Return all results but the cloud of points, by name, in SI units, for JSON."""
        numbers = {f.name: _plain(getattr(self, f.name)) for f in fields(self) if f.name != "draft"}
        origins = {path: list(quantity.origin) for path, quantity in self.draft.quantities.items()}
        return numbers | {"missing": list(self.draft.missing), "origins": origins}


def _plain(value: Any) -> Any:
    """Convert a value to JSON."""
    if is_dataclass(value):
        return {f.name: _plain(getattr(value, f.name)) for f in fields(value) if f.name != "points"}
    if isinstance(value, dict):
        return {name: _plain(entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


def check_robot(draft: RobotDraft) -> RobotCheck:
    """Compute all properties for which a description, complete or not, has the numbers."""

    def known(*needs: str) -> RobotDescription | None:
        return draft.description_for(*needs) if draft.can(*needs) else None

    # reach and poses
    shape = known("kinematics")
    rest = None if shape is None else rest_place(shape)
    places = () if shape is None else tuple(solve_poses(shape))
    reached = {place.name: place.q for place in places if place.q is not None}
    home = None if rest is None else rest.q
    # resonances and masses
    masses, links, elastic = known("kinematics", "links.mass"), known("link_torque"), known("locked_resonances")
    modes = None
    if elastic is not None:
        arm, with_rotors = RigidArm(elastic), draft.can("resonances")
        modes = {
            name: Resonances(locked=resonances(arm, q), free=resonances(arm, q, "free") if with_rotors else None)
            for name, q in reached.items()
        }
    weight = None
    if masses is not None:
        weight = float(masses.bodies.mass.sum()) + (0.0 if masses.tool is None else masses.tool.mass)
    with_gears = draft.can("link_torque", "drive.gear_ratio")
    # motors and servos at rest
    inertia = margin = servo = None
    if home is not None and rest is not None:
        driven, strong, whole = known("motor_torque"), known("torque_margin"), known("simulation")
        inertia = None if driven is None else compute_inertia(driven, home)
        margin = None if strong is None else compute_margin(strong, home)
        servo = None if whole is None else servo_loop(draft.complete(), rest.name, home)
    unreachable = [
        f"work_area.positions.{place.name} cannot be worked at: {place.problem}" for place in places if place.problem
    ]
    return RobotCheck(
        draft=draft,
        lacks={entry.name: draft.lacks(entry.name) for entry in CAPABILITIES},
        reach=None if shape is None else compute_reach(shape),
        rest=rest,
        places=places,
        mass=weight,
        resonances=modes or None,
        gravity=None if links is None else compute_gravity(links, reached, with_gears=with_gears),
        inertia=inertia,
        margin=margin,
        servo=servo,
        doubts=(*list_doubts(draft), *unreachable, *_servo_doubts(servo)),
    )


def _servo_doubts(servo: ServoLoop | None) -> list[str]:
    if servo is None:
        return []
    if servo.problem:
        return [f"servo: the robot does not rest at {servo.place}. {servo.problem}"]
    if not servo.stable:
        return [
            f"servo: the loop is unstable at {servo.place} without friction. Lower the gains, or simulation.physics_dt."
        ]
    if servo.gain_margin is not None and servo.gain_margin < _SMALL_MARGIN:
        return [f"servo: {servo.gain_margin:.2f} times the gains are unstable at {servo.place}; 2 or more is usual."]
    return []
