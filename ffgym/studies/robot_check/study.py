"""What a robot description says, lacks, allows and amounts to."""

from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.robot import CAPABILITIES, Capability, RigidArm, RobotDescription, RobotDraft, resonances
from ffgym.studies.robot_check.doubts import doubts_about
from ffgym.studies.robot_check.loads import (
    Gravity,
    Inertia,
    Margin,
    ServoLoop,
    gravity_of,
    inertia_of,
    margin_of,
    servo_loop,
)
from ffgym.studies.robot_check.shape import Place, Reach, places_of, reach_of, rest_place

_SMALL_MARGIN = 2.0
"""Gain margin below which a servo counts as tight; the rule of thumb of 6 dB."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Resonances:
    """Undamped resonances in one pose [Hz], ascending; rigid joints have none."""

    locked: Array
    """Motors held."""
    free: Array | None
    """Motors free; None where gear ratios or rotors are not known."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RobotCheck:
    """What was found; a part that the description does not say enough for is None."""

    draft: RobotDraft
    lacks: dict[str, tuple[str, ...]]
    """Entries that each capability lacks, by its name; empty where it works."""
    reach: Reach | None
    rest: Place | None
    """Home of the work area, or the joints nearest to 0."""
    places: tuple[Place, ...]
    """Positions of the work area; without one, the rest pose."""
    mass: float | None
    """Of all links and the tool [kg], without the base."""
    resonances: dict[str, Resonances] | None
    """By the name of the place."""
    gravity: Gravity | None
    inertia: Inertia | None
    margin: Margin | None
    servo: ServoLoop | None
    doubts: tuple[str, ...]

    def works(self, capability: Capability) -> bool:
        """Whether a function works."""
        return not self.lacks[capability.name]

    def numbers(self) -> dict[str, Any]:
        """All that was found but the cloud of points, by name, in SI units, as JSON has it."""
        numbers = {f.name: _plain(getattr(self, f.name)) for f in fields(self) if f.name != "draft"}
        origins = {path: list(quantity.origin) for path, quantity in self.draft.quantities.items()}
        return numbers | {"missing": list(self.draft.missing), "origins": origins}


def _plain(value: Any) -> Any:
    """A value as JSON has it."""
    if is_dataclass(value):
        return {f.name: _plain(getattr(value, f.name)) for f in fields(value) if f.name != "points"}
    if isinstance(value, dict):
        return {name: _plain(entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


def check_robot(draft: RobotDraft) -> RobotCheck:
    """Compute all that a description, complete or not, says enough for."""

    def known(*needs: str) -> RobotDescription | None:
        return draft.description_for(*needs) if draft.can(*needs) else None

    # where the arm is
    shape = known("kinematics")
    rest = None if shape is None else rest_place(shape)
    places = () if shape is None else tuple(places_of(shape))
    reached = {place.name: place.q for place in places if place.q is not None}
    home = None if rest is None else rest.q
    # how it bends, and what it weighs
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
    # what its motors and servos have to do with that at rest
    inertia = margin = servo = None
    if home is not None and rest is not None:
        driven, strong, whole = known("motor_torque"), known("torque_margin"), known("simulation")
        inertia = None if driven is None else inertia_of(driven, home)
        margin = None if strong is None else margin_of(strong, home)
        servo = None if whole is None else servo_loop(draft.complete(), rest.name, home)
    unreachable = [
        f"work_area.positions.{place.name} cannot be worked at: {place.problem}" for place in places if place.problem
    ]
    return RobotCheck(
        draft=draft,
        lacks={entry.name: draft.lacks(entry.name) for entry in CAPABILITIES},
        reach=None if shape is None else reach_of(shape),
        rest=rest,
        places=places,
        mass=weight,
        resonances=modes or None,
        gravity=None if links is None else gravity_of(links, reached, with_gears=with_gears),
        inertia=inertia,
        margin=margin,
        servo=servo,
        doubts=(*doubts_about(draft), *unreachable, *_servo_doubts(servo)),
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
