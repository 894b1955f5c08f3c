"""Where the numbers of a robot are found, and how large they usually are."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from ffgym.robot.template.proposals import (
    BRISTLE_TIME,
    DAMPING_TIME,
    PRESLIDING,
    STATIC_SHARE,
    STRIBECK_VELOCITY,
)


@dataclass(frozen=True, kw_only=True)
class Advice:
    """Help with one entry of a description."""

    where: str
    """Where to find it."""
    typical: str = ""
    """How large it usually is; empty where that says nothing."""
    sliding: str = ""
    """The same for a sliding joint, where its unit is another."""


_ARM_FILE = "the arm file, as a rule"
_FRAMES = "link frames stand on the joints and are parallel to the world at q = 0"
_TOOL_FRAME = "a frame of the arm file, named by tool_frame in [robot] instead of this table"
_FRICTION_TEST = (
    "constant speeds in both directions on one joint (thesis 6.1), or the controller's friction feed-forward"
)
_SERVO = "controller backup, or `ffgym robot fill`, which proposes gains from the inertias"

ADVICE: Mapping[str, Advice] = MappingProxyType(
    {
        "kinematics.position": Advice(where=_ARM_FILE),
        "kinematics.axis": Advice(where=_ARM_FILE),
        "kinematics.range": Advice(where="data sheet (working range), controller backup"),
        "kinematics.max_speed": Advice(where="data sheet (axis speeds)", typical="100 to 400 deg/s"),
        "base.mass": Advice(where=_ARM_FILE),
        "base.com": Advice(where=_ARM_FILE),
        "links.mass": Advice(where="CAD, data sheet (total mass), identification"),
        "links.com": Advice(where=f"CAD, identification; {_FRAMES}"),
        "links.inertia": Advice(where=f"CAD, identification; {_FRAMES}"),
        "flange.position": Advice(where=f"{_TOOL_FRAME}; data sheet (flange); left out, tool0 is at the last joint"),
        "flange.rotation": Advice(where=f"{_TOOL_FRAME}; manual (z out of the flange, as a rule)"),
        "tool.mass": Advice(where="controller backup (tool load data), scales"),
        "tool.com": Advice(where="controller backup (tool load data), CAD"),
        "tool.inertia": Advice(where="controller backup (tool load data), CAD"),
        "tool.tcp": Advice(where=f"{_TOOL_FRAME}; controller backup (tool frame), tool calibration"),
        "drive.gear_ratio": Advice(
            where="controller backup (transmission), data sheet, or motor turns counted over one joint turn",
            typical="50 to 250, direct drives 1",
            sliding="a screw of 10 mm a turn has 628 rad/m",
        ),
        "drive.coupling": Advice(where="manual of the wrist; left out, each motor turns one joint"),
        "drive.rotor_inertia": Advice(
            where="data sheet of the motor, with brake and gear input; without it, identification",
            typical="1e-5 (small wrist) to 1e-2 kg m^2; catalogues give kg cm^2, which is a unit here",
        ),
        "drive.joint_stiffness": Advice(
            where="data sheet of the gearbox, a load on the tool and a dial gauge, or the lowest resonances; inf for a "
            "joint that does not bend",
            typical="1e4 (small wrist) to 2e6 N m/rad",
        ),
        "drive.joint_damping": Advice(
            where=f"decay of a resonance; `ffgym robot fill` proposes {DAMPING_TIME:g} s x stiffness",
            typical="1e-4 to 1e-3 s x stiffness",
            sliding="1e-4 to 1e-3 s x stiffness",
        ),
        "drive.peak_torque": Advice(
            where="controller backup (torque limit), data sheet of the motor", typical="1 to 60 N m"
        ),
        "drive.torque_per_current": Advice(
            where="data sheet of the motor (torque constant), times the gear ratio where it counts behind the gearbox; "
            "left out, logs of currents need a scale in their column map",
            typical="0.05 to 1 N m/A at the motor",
        ),
        "drive.rated_torque": Advice(
            where="data sheet of the motor, drive parameters; left out, logs in percent need a scale in the column map",
            typical="0.1 to 30 N m",
        ),
        "friction.coulomb": Advice(where=_FRICTION_TEST, typical="2 to 10 % of the peak torque"),
        "friction.static": Advice(
            where=f"torque at which the joint starts to move; `ffgym robot fill` proposes {STATIC_SHARE:g} x coulomb",
            typical="1.0 to 1.5 x coulomb",
        ),
        "friction.viscous": Advice(where=_FRICTION_TEST, typical="as much as coulomb at 10 to 100 rad/s"),
        "friction.stribeck_velocity": Advice(
            where=f"speed below which friction falls; `ffgym robot fill` proposes {STRIBECK_VELOCITY:g} rad/s",
            typical="0.05 to 5 rad/s",
        ),
        "friction.bristle_stiffness": Advice(
            where="slope of torque over motor angle just after a reversal; `ffgym robot fill` proposes coulomb / "
            f"{PRESLIDING * 1e3:g} mrad",
            typical="coulomb over 1 to 20 mrad",
        ),
        "friction.bristle_damping": Advice(
            where=f"hardly to be measured; `ffgym robot fill` proposes {BRISTLE_TIME * 1e3:g} ms x bristle stiffness",
            typical="1 to 10 ms x bristle stiffness",
        ),
        "servo.position_gain": Advice(where=_SERVO),
        "servo.velocity_gain": Advice(where=_SERVO),
        "servo.integral_gain": Advice(where=_SERVO),
        "servo.control_dt": Advice(where="controller manual (interpolation or path cycle)", typical="0.5 to 12 ms"),
        "sensors.encoder_bits": Advice(where="data sheet of the motor", typical="12 to 24"),
        "sensors.tracker_noise": Advice(where="data sheet of the tracker; left out, there is none"),
        "sensors.tracker_period": Advice(where="data sheet of the tracker; left out, there is none"),
        "simulation.physics_dt": Advice(where="your choice", typical="0.1 to 0.5 ms"),
        "simulation.gravity": Advice(where="how the robot is mounted: floor [0, 0, -9.81], ceiling [0, 0, 9.81]"),
        "work_area.tool_rotation": Advice(where="how the tool stands while it works"),
        "work_area.normal": Advice(where="upwards off the plane that the tool works in"),
        "work_area.home": Advice(
            where="a pose near the work, off singularities; jog the robot there and read the joints"
        ),
    }
)  # fmt: skip
"""Advice by entry of a description."""
