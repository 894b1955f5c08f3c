"""What a robot description says, lacks, allows and amounts to."""

from dataclasses import asdict, dataclass, fields, is_dataclass
from typing import Any

from ffgym.core.types import Array
from ffgym.robot import CAPABILITIES, Capability, RigidArm, RobotDraft, resonances
from ffgym.studies.robot_check.circle_use import CircleUse, circle_use
from ffgym.studies.robot_check.doubts import doubts_about
from ffgym.studies.robot_check.loads import Gravity, Inertia, Margin, gravity_of, inertia_of, margin_of
from ffgym.studies.robot_check.places import Place, Reach, places_of, reach_of, rest_place
from ffgym.studies.robot_check.servo_loop import ServoLoop, servo_loop

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
    has_shape = draft.can("kinematics")
    shape = draft.description_for("kinematics") if has_shape else None
    rest = None if shape is None else rest_place(shape)
    places = () if shape is None else tuple(places_of(shape))
    reached = {place.name: place.q for place in places if place.q is not None}
    servo = _servo(draft, rest)
    return RobotCheck(
        draft=draft,
        lacks={entry.name: draft.lacks(entry.name) for entry in CAPABILITIES},
        reach=None if shape is None else reach_of(shape),
        rest=rest,
        places=places,
        mass=_mass(draft),
        resonances=_resonances(draft, reached),
        gravity=_gravity(draft, reached),
        inertia=_inertia(draft, rest),
        margin=_margin(draft, rest),
        circles=circle_use(draft.complete()) if draft.can("circles") else None,
        servo=servo,
        doubts=(*doubts_about(draft), *_place_doubts(places), *_servo_doubts(servo)),
    )


def _mass(draft: RobotDraft) -> float | None:
    if not draft.can("kinematics", "links.mass"):
        return None
    robot = draft.description_for("kinematics", "links.mass")
    return float(robot.bodies.mass.sum()) + (0.0 if robot.tool is None else robot.tool.mass)


def _resonances(draft: RobotDraft, places: dict[str, Array]) -> dict[str, Resonances] | None:
    if not draft.can("locked_resonances"):
        return None
    arm, free = RigidArm(draft.description_for("locked_resonances")), draft.can("resonances")
    return {
        name: Resonances(locked=resonances(arm, q), free=resonances(arm, q, "free") if free else None)
        for name, q in places.items()
    }


def _gravity(draft: RobotDraft, places: dict[str, Array]) -> Gravity | None:
    if not draft.can("link_torque"):
        return None
    with_gears = draft.can("link_torque", "drive.gear_ratio")
    return gravity_of(draft.description_for("link_torque"), places, with_gears=with_gears)


def _inertia(draft: RobotDraft, rest: Place | None) -> Inertia | None:
    if rest is None or rest.q is None or not draft.can("motor_torque"):
        return None
    return inertia_of(draft.description_for("motor_torque"), rest.q)


def _margin(draft: RobotDraft, rest: Place | None) -> Margin | None:
    if rest is None or rest.q is None or not draft.can("torque_margin"):
        return None
    return margin_of(draft.description_for("torque_margin"), rest.q)


def _servo(draft: RobotDraft, rest: Place | None) -> ServoLoop | None:
    if rest is None or rest.q is None or not draft.can("simulation"):
        return None
    return servo_loop(draft.complete(), rest.name, rest.q)


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
