"""What a robot description must and may contain."""

from collections.abc import Mapping
from types import MappingProxyType

from ffgym.robot.rule import LINK, MOTOR, Rule


def _motor(unit: str, slide_unit: str, *, power: int, open_low: bool = True) -> Rule:
    """Positive quantity of each motor; `slide_unit` is that of a sliding joint, where it is given on the link side."""
    return Rule(
        shape=("N",), unit=unit, slide_unit=slide_unit, side=MOTOR, gear_power=power, low=0.0, open_low=open_low
    )


def _link(unit: str, slide_unit: str, *, power: int, open_low: bool = True, infinite: bool = False) -> Rule:
    """Positive quantity of each joint behind the gearbox."""
    return Rule(
        shape=("N",),
        unit=unit,
        slide_unit=slide_unit,
        side=LINK,
        gear_power=power,
        low=0.0,
        open_low=open_low,
        infinite=infinite,
    )


RULES: Mapping[str, Rule] = MappingProxyType(
    {
        "kinematics.position": Rule(shape=("N", 3), unit="m"),
        "kinematics.axis": Rule(shape=("N", 3), unit="1"),
        "kinematics.range": Rule(shape=("N", 2), unit="rad", side="link", slide_unit="m"),
        "kinematics.max_speed": Rule(shape=("N",), unit="rad/s", side="link", low=0.0, open_low=True, slide_unit="m/s"),
        "base.mass": Rule(shape=(), unit="kg", low=0.0, open_low=True),
        "base.com": Rule(shape=(3,), unit="m"),
        "links.mass": Rule(shape=("N",), unit="kg", side="link", low=0.0, open_low=True),
        "links.com": Rule(shape=("N", 3), unit="m", side="link"),
        "links.inertia": Rule(shape=("N", 6), unit="kg m^2", side="link"),
        "flange.position": Rule(shape=(3,), unit="m", optional=True),
        "flange.rotation": Rule(shape=(3, 3), unit="1", optional=True),
        "tool.mass": Rule(shape=(), unit="kg", optional=True, low=0.0),
        "tool.com": Rule(shape=(3,), unit="m", optional=True),
        "tool.inertia": Rule(shape=(6,), unit="kg m^2", optional=True),
        "tool.tcp": Rule(shape=(3,), unit="m", optional=True),
        "drive.gear_ratio": Rule(shape=("N",), unit="1", nonzero=True, slide_unit="rad/m"),
        "drive.coupling": Rule(shape=("N", "N"), unit="1", optional=True),
        "drive.rotor_inertia": _motor("kg m^2", "kg", power=-2),
        "drive.joint_stiffness": _link("N m/rad", "N/m", power=-2, infinite=True),
        "drive.joint_damping": _link("N m s/rad", "N s/m", power=-2, open_low=False),
        "drive.peak_torque": _motor("N m", "N", power=-1),
        "friction.coulomb": _motor("N m", "N", power=-1),
        "friction.static": _motor("N m", "N", power=-1),
        "friction.viscous": _motor("N m s/rad", "N s/m", power=-2, open_low=False),
        "friction.stribeck_velocity": _motor("rad/s", "m/s", power=1),
        "friction.bristle_stiffness": _motor("N m/rad", "N/m", power=-2),
        "friction.bristle_damping": _motor("N m s/rad", "N s/m", power=-2, open_low=False),
        "servo.position_gain": _motor("N m/rad", "N/m", power=-2),
        "servo.velocity_gain": _motor("N m s/rad", "N s/m", power=-2, open_low=False),
        "servo.integral_gain": _motor("N m/(rad s)", "N/(m s)", power=-2, open_low=False),
        "servo.control_dt": Rule(shape=(), unit="s", low=0.0, open_low=True),
        "sensors.encoder_bits": Rule(shape=(), unit="bit/turn", side="motor", low=1.0),
        "sensors.tracker_noise": Rule(shape=(), unit="m", low=0.0, optional=True),
        "sensors.tracker_period": Rule(shape=(), unit="s", optional=True, low=0.0, open_low=True),
        "simulation.physics_dt": Rule(shape=(), unit="s", low=0.0, open_low=True),
        "simulation.gravity": Rule(shape=(3,), unit="m/s^2"),
        "work_area.tool_rotation": Rule(shape=(3, 3), unit="1", optional=True),
        "work_area.home": Rule(shape=("N",), unit="rad", side="link", optional=True, slide_unit="m"),
    }
)
"""What a description must contain; optional entries may be left out."""

POINT = Rule(shape=(3,), unit="m")
"""A named point of the work area."""

SPRING_RULES: Mapping[str, Rule] = MappingProxyType(
    {
        "start": POINT,
        "end": POINT,
        "length": Rule(shape=(), unit="m", low=0.0),
        "stiffness": Rule(shape=(), unit="N/m"),
        "stiffness_2": Rule(shape=(), unit="N/m^2", optional=True),
        "stiffness_3": Rule(shape=(), unit="N/m^3", optional=True),
    }
)
"""What a table [springs.<name>] must contain, beside the names of the bodies that it joins."""
