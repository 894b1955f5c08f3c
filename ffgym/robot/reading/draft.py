"""Drafts: descriptions that may lack entries, with the capabilities that their entries allow."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, errors_at
from ffgym.core.types import Array
from ffgym.robot.description import RobotDescription
from ffgym.robot.drive import Drive
from ffgym.robot.friction import LuGreParameters
from ffgym.robot.parts import Geom, Kinematics, Links, Logs, Sensors, Servo, Spring, Tool, WorkArea
from ffgym.robot.reading.quantity import Quantity
from ffgym.robot.reading.rules import CAPABILITIES, POSITIONS, REQUIRED, RULES, capability

FLANGE = ("flange.rotation", "tool.tcp")
TOOL_MASSES = ("tool.mass", "tool.com", "tool.inertia")
HOME = "work_area.home"
_POINTS = "work_area.positions."


def assemble(get: Mapping[str, Any], types: tuple[str, ...]) -> dict[str, Any]:
    """Collect numeric fields of a `RobotDescription` from values by entry; all that are required must be there."""
    for path, missing in begun(get).items():
        raise FFGymError(f"{', '.join(missing)} is missing, which {path} needs.")
    bits = float(get["sensors.encoder_bits"])
    if bits != round(bits):
        raise FFGymError(f"sensors.encoder_bits = {bits} must be a whole number.")
    return {
        "kinematics": _group(Kinematics, "kinematics", get, types=types),
        "base_mass": float(get["base.mass"]),
        "base_com": get["base.com"],
        "bodies": _group(Links, "links", get),
        "tool": _tool(get),
        "drive": _group(Drive, "drive", get, resolver_period=float(get.get("drive.resolver_period", 0.0))),
        "friction": _group(LuGreParameters, "friction", get),
        "servo": _group(Servo, "servo", get, control_dt=float(get["servo.control_dt"])),
        "sensors": Sensors(
            encoder_bits=round(bits),
            tracker_noise=float(get.get("sensors.tracker_noise", 0.0)),
            tracker_period=float(get.get("sensors.tracker_period", 0.0)),
        ),
        "physics_dt": float(get["simulation.physics_dt"]),
        "gravity": get["simulation.gravity"],
        "work_area": _work_area(get),
    }


def begun(paths: Mapping[str, Any]) -> dict[str, tuple[str, ...]]:
    """Entries that others of their group call for, by one of those that are there; empty if all groups are whole."""
    groups = [(TOOL_MASSES, TOOL_MASSES), (FLANGE, FLANGE), (("flange.position", *TOOL_MASSES), FLANGE)]
    groups += [(tuple(path for path in paths if path.startswith("work_area.")), (HOME,))]
    found: dict[str, tuple[str, ...]] = {}
    for given, wanted in groups:
        missing = tuple(path for path in wanted if path not in paths)
        found |= {path: missing for path in given if path in paths and missing}
    return found


def _group(cls: Any, prefix: str, get: Mapping[str, Any], **others: Any) -> Any:
    """Build a dataclass from the quantities below `prefix`, and from `others`."""
    values = {path.removeprefix(prefix + "."): value for path, value in get.items() if path.startswith(prefix + ".")}
    return cls(**(values | others))


def _tool(get: Mapping[str, Any]) -> Tool | None:
    if FLANGE[0] not in get:
        return None
    body = {path.removeprefix("tool."): get[path] for path in TOOL_MASSES if path in get}
    return Tool(
        rotation=get["flange.rotation"],
        position=get.get("flange.position", np.zeros(3)),
        tcp=get["tool.tcp"],
        **(body | {"mass": float(body.get("mass", 0.0))}),
    )


def _work_area(get: Mapping[str, Any]) -> WorkArea | None:
    if HOME not in get:
        return None
    return WorkArea(
        positions={path.removeprefix(_POINTS): value for path, value in get.items() if path.startswith(_POINTS)},
        tool_rotation=get.get("work_area.tool_rotation"),
        normal=get.get("work_area.normal", np.array([0.0, 0.0, 1.0])),
        home=get[HOME],
    )


NO_LIMIT = 1e6
"""Stand-in for peak torques [N m]: more than any drive gives, so that none is taken for saturated."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RobotDraft:
    """Draft of a robot, as a file gives it. All entries have been checked; none is required."""

    where: str
    """Name of the file or text, for messages."""
    name: str
    title: str
    joints: tuple[str, ...]
    links: tuple[str, ...]
    types: tuple[str, ...]
    """'hinge' or 'slide', one per joint."""
    quantities: Mapping[str, Quantity]
    waiting: tuple[str, ...] = ()
    """Entries given on the other side of the gearbox, which count once drive.gear_ratio is there."""
    springs: tuple[Spring, ...] = ()
    logs: Logs
    geoms: tuple[Geom, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "quantities", MappingProxyType(dict(self.quantities)))

    @property
    def missing(self) -> tuple[str, ...]:
        """Entries without which the robot is not complete, in the order of the rules."""
        return self._without((*REQUIRED, *self._half_given()))

    def lacks(self, name: str, *also: str) -> tuple[str, ...]:
        """Entries that a capability (`ffgym.robot.reading.draft`), and entries `also` needed, still lack."""
        half_given = () if name == "kinematics" else self._half_given()
        return self._without((*capability(name).needs, *also, *half_given))

    def can(self, name: str, *also: str) -> bool:
        """Tell if a capability works with the entries that exist, and the entries `also` exist."""
        return not self.lacks(name, *also)

    def complete(self) -> RobotDescription:
        """Build the robot.

        Raises:
            FFGymError: if entries are missing; the message says which, and what does not work without them.
        """
        missing = sorted(self._without(REQUIRED))
        if missing:
            lost = [entry.title for entry in CAPABILITIES if not self.can(entry.name)]
            raise FFGymError(
                f"{self.where}: Missing entries: {', '.join(missing)}. Without them these do not work: "
                f"{'; '.join(lost)}. "
                f"`ffgym robot check {self.where}` says what works, and what would be proposed."
            )
        with errors_at(self.where):
            return self._assemble({path: quantity.value for path, quantity in self.quantities.items()})

    def description_for(self, name: str, *also: str) -> RobotDescription:
        """Build a description for one capability, and for the entries `also`.

        Entries that it lacks and the capability does not need are stand-ins, which the results do not depend on; they
        are not among its `quantities`.

        Raises:
            FFGymError: if the capability lacks entries.
        """
        lacking = self.lacks(name, *also)
        if lacking:
            raise FFGymError(f"{self.where}: {capability(name).title}: there is no {', '.join(lacking)}.")
        return self._with_stand_ins()

    def check(self) -> None:
        """Check that what is there fits together."""
        self._with_stand_ins()

    def _half_given(self) -> tuple[str, ...]:
        """Entries that others of their group call for."""
        return tuple(path for missing in begun(self.quantities).values() for path in missing)

    def _without(self, wanted: tuple[str, ...]) -> tuple[str, ...]:
        """List entries of `wanted` that are absent, each once; the gear ratios for those that wait for them."""
        paths = ("drive.gear_ratio" if path in self.waiting else path for path in wanted)
        points = {POSITIONS for path in self.quantities if path.startswith(f"{POSITIONS}.")}
        return tuple(dict.fromkeys(path for path in paths if path not in self.quantities and path not in points))

    def _with_stand_ins(self) -> RobotDescription:
        unfinished = begun(self.quantities)
        values = {path: quantity.value for path, quantity in self.quantities.items() if path not in unfinished}
        return self._assemble(stand_ins(values, len(self.joints)) | values)

    def _assemble(self, values: Mapping[str, Array]) -> RobotDescription:
        return RobotDescription(
            name=self.name,
            title=self.title,
            joints=self.joints,
            links=self.links,
            geoms=self.geoms,
            springs=self.springs,
            logs=self.logs,
            quantities=self.quantities,
            **assemble(values, self.types),
        )


def stand_ins(values: Mapping[str, Array], n_joints: int, size: float = 1.0) -> dict[str, Array]:
    """Valid numbers of about `size` for all required entries, with those of `values` that they must fit."""
    ins = {path: np.full(RULES[path].shape_for(n_joints), size) for path in REQUIRED}
    ins["kinematics.axis"] = np.tile([0.0, 0.0, 1.0], (n_joints, 1))
    home = np.broadcast_to(values.get("work_area.home", 0.0), n_joints)
    ins["kinematics.range"] = np.column_stack([np.minimum(-size, home), np.maximum(size, home)])
    ins["links.inertia"] = np.tile([size, size, size, 0.0, 0.0, 0.0], (n_joints, 1))
    ins["sensors.encoder_bits"] = np.array(16.0)
    ins["drive.peak_torque"] = np.full(n_joints, NO_LIMIT)
    for first, second in (("friction.coulomb", "friction.static"), ("servo.control_dt", "simulation.physics_dt")):
        ins[first], ins[second] = values.get(second, ins[first]), values.get(first, ins[second])
    return ins
