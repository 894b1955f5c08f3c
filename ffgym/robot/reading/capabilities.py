"""What can be done with a robot, and which entries of its description each function needs."""

from dataclasses import dataclass

from ffgym.core.errors import FFGymError
from ffgym.robot.reading.rules import RULES

_GEOMETRY = ("kinematics.position", "kinematics.axis", "kinematics.range")
_MASSES = ("links.mass", "links.com", "links.inertia")
_LOADS = (*_MASSES, "simulation.gravity")
_MOTION = ("kinematics.max_speed", "servo.control_dt")
_STATIC_FRICTION = ("friction.coulomb", "friction.static", "friction.viscous", "friction.stribeck_velocity")
_FRICTION = (*_STATIC_FRICTION, "friction.bristle_stiffness", "friction.bristle_damping")
_TOOL = ("flange.rotation", "tool.tcp")
_WORK_AREA = ("work_area.home",)
POSITIONS = "work_area.positions"
"""Stands for one named point or more."""
_SIMULATION = tuple(path for path, rule in RULES.items() if not rule.optional)


@dataclass(frozen=True, kw_only=True)
class Capability:
    """A function of the library, or a group of them."""

    name: str
    """For code and JSON."""
    title: str
    """What works, in words."""
    needs: tuple[str, ...]
    """Entries of the description without which it does not work."""


CAPABILITIES: tuple[Capability, ...] = (
    Capability(name="kinematics", title="kinematics, reach, pictures", needs=_GEOMETRY),
    Capability(name="joint_motions", title="motions in joint space", needs=(*_GEOMETRY, *_MOTION)),
    Capability(name="tool_paths", title="paths of the tool", needs=(*_GEOMETRY, *_MOTION, *_TOOL, *_WORK_AREA)),
    Capability(
        name="link_torque", title="gravity and inertia torque behind the gearbox", needs=(*_GEOMETRY, *_LOADS)
    ),
    Capability(
        name="identification",
        title="masses from logs of the machine: ffgym identify --what rigid_body",
        needs=(*_GEOMETRY, "simulation.gravity", "drive.gear_ratio"),
    ),
    Capability(
        name="motor_torque",
        title="motor torque of the rigid arm, rigid feed-forward",
        needs=(*_GEOMETRY, *_LOADS, "drive.gear_ratio", "drive.rotor_inertia"),
    ),
    Capability(
        name="torque_margin",
        title="torque margin of the motors",
        needs=(
            *_GEOMETRY, "kinematics.max_speed", *_LOADS, "drive.gear_ratio", "drive.rotor_inertia",
            "drive.peak_torque", "friction.coulomb", "friction.static", "friction.viscous",
            "friction.stribeck_velocity",
        ),
    ),
    Capability(
        name="locked_resonances",
        title="resonances with the motors held",
        needs=(*_GEOMETRY, *_MASSES, "drive.joint_stiffness"),
    ),
    Capability(
        name="resonances",
        title="resonances with the motors free",
        needs=(*_GEOMETRY, *_MASSES, "drive.joint_stiffness", "drive.gear_ratio", "drive.rotor_inertia"),
    ),
    Capability(
        name="lugre_static",
        title="static LuGre feed-forward",
        needs=(*_GEOMETRY, *_MOTION, "drive.gear_ratio", *_STATIC_FRICTION),
    ),
    Capability(
        name="lugre_dynamic",
        title="dynamic LuGre feed-forward",
        needs=(*_GEOMETRY, *_MOTION, "drive.gear_ratio", *_FRICTION),
    ),
    Capability(
        name="elastic",
        title="feed-forward that leads by what the joints bend",
        needs=(
            *_GEOMETRY, *_MOTION, *_LOADS, "drive.gear_ratio", "drive.rotor_inertia", "drive.joint_stiffness",
            "drive.joint_damping", *_FRICTION, "servo.position_gain", "servo.velocity_gain", "servo.integral_gain",
        ),
    ),
    Capability(name="simulation", title="simulation, environments, learning, export", needs=_SIMULATION),
    Capability(
        name="circles", title="circles in the work area", needs=(*_SIMULATION, *_TOOL, *_WORK_AREA, POSITIONS)
    ),
)  # fmt: skip
"""Everything, from what needs least to what needs most."""


def capability(name: str) -> Capability:
    """The capability of that name.

    Raises:
        FFGymError: if there is none.
    """
    for entry in CAPABILITIES:
        if entry.name == name:
            return entry
    raise FFGymError(f"Unknown capability {name!r}. Available: {', '.join(entry.name for entry in CAPABILITIES)}.")


def needed_by(path: str) -> tuple[Capability, ...]:
    """What does not work without an entry."""
    return tuple(entry for entry in CAPABILITIES if path in entry.needs)
