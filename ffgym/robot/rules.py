"""What a robot description must and may contain."""

from collections.abc import Mapping
from types import MappingProxyType

from ffgym.robot.quantity import Rule

RULES: Mapping[str, Rule] = MappingProxyType(
    {
        "kinematics.position": Rule(shape=("N", 3), unit="m"),
        "kinematics.axis": Rule(shape=("N", 3), unit="1"),
        "kinematics.range": Rule(shape=("N", 2), unit="rad", side="link"),
        "kinematics.max_speed": Rule(shape=("N",), unit="rad/s", side="link", low=0.0, open_low=True),
        "base.mass": Rule(shape=(), unit="kg", low=0.0, open_low=True),
        "base.com": Rule(shape=(3,), unit="m"),
        "links.mass": Rule(shape=("N",), unit="kg", side="link", low=0.0, open_low=True),
        "links.com": Rule(shape=("N", 3), unit="m", side="link"),
        "links.inertia": Rule(shape=("N", 6), unit="kg m^2", side="link"),
        "flange.rotation": Rule(shape=(3, 3), unit="1", optional=True),
        "tool.mass": Rule(shape=(), unit="kg", optional=True, low=0.0, open_low=True),
        "tool.com": Rule(shape=(3,), unit="m", optional=True),
        "tool.inertia": Rule(shape=(6,), unit="kg m^2", optional=True),
        "tool.tcp": Rule(shape=(3,), unit="m", optional=True),
        "drive.gear_ratio": Rule(shape=("N",), unit="1", low=0.0, open_low=True),
        "drive.rotor_inertia": Rule(shape=("N",), unit="kg m^2", side="motor", low=0.0, open_low=True),
        "drive.joint_stiffness": Rule(shape=("N",), unit="N m/rad", side="link", infinite=True, low=0.0, open_low=True),
        "drive.joint_damping": Rule(shape=("N",), unit="N m s/rad", side="link", low=0.0),
        "drive.peak_torque": Rule(shape=("N",), unit="N m", side="motor", low=0.0, open_low=True),
        "friction.coulomb": Rule(shape=("N",), unit="N m", side="motor", low=0.0, open_low=True),
        "friction.static": Rule(shape=("N",), unit="N m", side="motor", low=0.0, open_low=True),
        "friction.viscous": Rule(shape=("N",), unit="N m s/rad", side="motor", low=0.0),
        "friction.stribeck_velocity": Rule(shape=("N",), unit="rad/s", side="motor", low=0.0, open_low=True),
        "friction.bristle_stiffness": Rule(shape=("N",), unit="N m/rad", side="motor", low=0.0, open_low=True),
        "friction.bristle_damping": Rule(shape=("N",), unit="N m s/rad", side="motor", low=0.0),
        "servo.position_gain": Rule(shape=("N",), unit="N m/rad", side="motor", low=0.0, open_low=True),
        "servo.velocity_gain": Rule(shape=("N",), unit="N m s/rad", side="motor", low=0.0),
        "servo.integral_gain": Rule(shape=("N",), unit="N m/(rad s)", side="motor", low=0.0),
        "servo.control_dt": Rule(shape=(), unit="s", low=0.0, open_low=True),
        "sensors.encoder_bits": Rule(shape=(), unit="bit/turn", side="motor", low=1.0),
        "sensors.tracker_noise": Rule(shape=(), unit="m", low=0.0, optional=True),
        "sensors.tracker_period": Rule(shape=(), unit="s", optional=True, low=0.0, open_low=True),
        "simulation.physics_dt": Rule(shape=(), unit="s", low=0.0, open_low=True),
        "simulation.gravity": Rule(shape=(3,), unit="m/s^2"),
        "work_area.tool_rotation": Rule(shape=(3, 3), unit="1", optional=True),
        "work_area.home": Rule(shape=("N",), unit="rad", side="link", optional=True),
    }
)
"""What a description must contain; optional entries may be left out."""

POINT = Rule(shape=(3,), unit="m")
"""A named point of the work area."""
