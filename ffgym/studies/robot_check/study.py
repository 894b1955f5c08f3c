"""What a robot description says, lacks, allows and amounts to."""

from dataclasses import asdict, dataclass, fields, is_dataclass
from typing import Any

from ffgym.core.types import Array
from ffgym.robot import CAPABILITIES, Capability, RigidArm, RobotDescription, RobotDraft, resonances
from ffgym.studies.robot_check.doubts import doubts_about
from ffgym.studies.robot_check.loads import (
    CircleUse,
    Gravity,
    Inertia,
    Margin,
    circle_use,
    gravity_of,
    inertia_of,
    margin_of,
)
from ffgym.studies.robot_check.servo_loop import ServoLoop, servo_loop
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
    circles: CircleUse | None
    servo: ServoLoop | None
    doubts: tuple[str, ...]

    def works(self, capability: Capability) -> bool:
        """Whether a function works."""
        return not self.lacks[capability.name]

    def numbers(self) -> dict[str, Any]:
        """All that was found but the cloud of points, by name, in SI units; arrays as they are."""
        found = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in ("draft", "resonances")}
        numbers = {
            name: asdict(value) if is_dataclass(value) and not isinstance(value, type) else value
            for name, value in found.items()
        }
        numbers["places"] = [asdict(place) for place in self.places]
        if self.reach is not None:
            del numbers["reach"]["points"]
        numbers["resonances"] = {name: asdict(entry) for name, entry in (self.resonances or {}).items()} or None
        origins = {path: list(quantity.origin) for path, quantity in self.draft.quantities.items()}
        return numbers | {"missing": self.draft.missing, "origins": origins}


def check_robot(draft: RobotDraft) -> RobotCheck:
    """Compute all that a description, complete or not, says enough for."""

    def known(*needs: str) -> RobotDescription | None:
        return draft.description_for(*needs) if draft.can(*needs) else None

    shape, masses, links = known("kinematics"), known("kinematics", "links.mass"), known("link_torque")
    rest = None if shape is None else rest_place(shape)
    places = () if shape is None else tuple(places_of(shape))
    reached = {place.name: place.q for place in places if place.q is not None}
    at = None if rest is None else rest.q
    driven, strong, whole = (
        None if at is None else known(needs) for needs in ("motor_torque", "torque_margin", "simulation")
    )
    with_gears = draft.can("link_torque", "drive.gear_ratio")
    servo = servo_loop(draft.complete(), rest.name, at) if whole and rest is not None and at is not None else None
    return RobotCheck(
        draft=draft,
        lacks={entry.name: draft.lacks(entry.name) for entry in CAPABILITIES},
        reach=None if shape is None else reach_of(shape),
        rest=rest,
        places=places,
        mass=None if masses is None else _mass(masses),
        resonances=_resonances(known("locked_resonances"), reached, free=draft.can("resonances")),
        gravity=None if links is None else gravity_of(links, reached, with_gears=with_gears),
        inertia=None if driven is None or at is None else inertia_of(driven, at),
        margin=None if strong is None or at is None else margin_of(strong, at),
        circles=circle_use(draft.complete()) if draft.can("circles") else None,
        servo=servo,
        doubts=(*doubts_about(draft), *_place_doubts(places), *_servo_doubts(servo)),
    )


def _mass(robot: RobotDescription) -> float:
    return float(robot.bodies.mass.sum()) + (0.0 if robot.tool is None else robot.tool.mass)


def _resonances(
    robot: RobotDescription | None, places: dict[str, Array], *, free: bool
) -> dict[str, Resonances] | None:
    if robot is None:
        return None
    arm = RigidArm(robot)
    return {
        name: Resonances(locked=resonances(arm, q), free=resonances(arm, q, "free") if free else None)
        for name, q in places.items()
    }


def _place_doubts(places: tuple[Place, ...]) -> list[str]:
    return [
        f"work_area.positions.{place.name} cannot be worked at: {place.problem}" for place in places if place.problem
    ]


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
