"""What a robot description must and may contain."""

from collections.abc import Mapping
from types import MappingProxyType

from ffgym.robot.reading.quantity import LINK, MOTOR, Rule


def _motor(meaning: str, unit: str, slide_unit: str, *, power: int, open_low: bool = True) -> Rule:
    """Positive quantity of each motor; `slide_unit` is that of a sliding joint, where it is given on the link side."""
    return Rule(
        meaning=meaning,
        shape=("N",),
        unit=unit,
        slide_unit=slide_unit,
        side=MOTOR,
        gear_power=power,
        low=0.0,
        open_low=open_low,
    )


def _unit_of_logs(meaning: str, unit: str, slide_unit: str) -> Rule:
    """Torque of each motor per unit of what its controller logs; it may turn the other way round."""
    return Rule(
        meaning=meaning,
        shape=("N",),
        unit=unit,
        slide_unit=slide_unit,
        side=MOTOR,
        gear_power=-1,
        signed=True,
        nonzero=True,
        optional=True,
    )


def _link(
    meaning: str, unit: str, slide_unit: str, *, power: int, open_low: bool = True, infinite: bool = False
) -> Rule:
    """Positive quantity of each joint behind the gearbox."""
    return Rule(
        meaning=meaning,
        shape=("N",),
        unit=unit,
        slide_unit=slide_unit,
        side=LINK,
        gear_power=power,
        low=0.0,
        open_low=open_low,
        infinite=infinite,
    )


SHORTEST_STEP = 1e-6
"""Physics step [s], a million steps for a second; a shorter one is a slip of unit, and fills any memory."""

RULES: Mapping[str, Rule] = MappingProxyType(
    {
        "kinematics.position": Rule(
            meaning="origin of each joint in the previous link frame", shape=("N", 3), unit="m"
        ),
        "kinematics.axis": Rule(meaning="unit axis of each joint", shape=("N", 3), unit="1"),
        "kinematics.range": Rule(
            meaning="lower and upper joint limit", shape=("N", 2), unit="rad", side="link", slide_unit="m"
        ),
        "kinematics.max_speed": Rule(
            meaning="joint speed limit",
            shape=("N",),
            unit="rad/s",
            side="link",
            low=0.0,
            open_low=True,
            slide_unit="m/s",
        ),
        "base.mass": Rule(meaning="mass of the fixed base", shape=(), unit="kg", low=0.0),
        "base.com": Rule(meaning="centre of mass of the base", shape=(3,), unit="m"),
        "links.mass": Rule(meaning="mass of each link", shape=("N",), unit="kg", side="link", low=0.0, open_low=True),
        "links.com": Rule(meaning="centre of mass of each link in its frame", shape=("N", 3), unit="m", side="link"),
        "links.inertia": Rule(
            meaning="inertia of each link about its centre of mass: xx, yy, zz, xy, xz, yz",
            shape=("N", 6),
            unit="kg m^2",
            side="link",
        ),
        "flange.position": Rule(
            meaning="origin of tool0 in the last link frame; 0 if left out", shape=(3,), unit="m", optional=True
        ),
        "flange.rotation": Rule(
            meaning="orientation of tool0 in the last link frame", shape=(3, 3), unit="1", optional=True
        ),
        "tool.mass": Rule(meaning="mass of the tool", shape=(), unit="kg", optional=True, low=0.0),
        "tool.com": Rule(meaning="centre of mass of the tool in tool0", shape=(3,), unit="m", optional=True),
        "tool.inertia": Rule(
            meaning="inertia of the tool about its centre of mass, tool0 axes: xx, yy, zz, xy, xz, yz",
            shape=(6,),
            unit="kg m^2",
            optional=True,
        ),
        "tool.tcp": Rule(meaning="tool centre point in tool0", shape=(3,), unit="m", optional=True),
        "drive.gear_ratio": Rule(
            meaning="motor turns per joint turn; negative where they turn opposite ways",
            shape=("N",),
            unit="1",
            nonzero=True,
            slide_unit="rad/m",
        ),
        "drive.coupling": Rule(
            meaning="how far motor i turns per turn of joint j when joint i stands still; 0 on the diagonal",
            shape=("N", "N"),
            unit="1",
            optional=True,
        ),
        "drive.rotor_inertia": _motor("motor and gear input inertia", "kg m^2", "kg", power=-2),
        "drive.joint_stiffness": _link(
            "elasticity between gearbox and arm; `inf` is a rigid joint", "N m/rad", "N/m", power=-2, infinite=True
        ),
        "drive.joint_damping": _link(
            "damping of the elasticity between gearbox and arm", "N m s/rad", "N s/m", power=-2, open_low=False
        ),
        "drive.peak_torque": _motor("largest torque the drive gives", "N m", "N", power=-1),
        "drive.torque_per_current": _unit_of_logs(
            "torque per ampere of motor current, for logs of currents", "N m/A", "N/A"
        ),
        "drive.rated_torque": _unit_of_logs("torque at 100 %, for logs in percent of a rated torque", "N m", "N"),
        "friction.coulomb": _motor("Coulomb torque f_c", "N m", "N", power=-1),
        "friction.static": _motor("breakaway torque f_s, >= f_c", "N m", "N", power=-1),
        "friction.viscous": _motor("viscous coefficient f_v", "N m s/rad", "N s/m", power=-2, open_low=False),
        "friction.stribeck_velocity": _motor("Stribeck velocity v_s", "rad/s", "m/s", power=1),
        "friction.bristle_stiffness": _motor("bristle stiffness sigma_0", "N m/rad", "N/m", power=-2),
        "friction.bristle_damping": _motor("bristle damping sigma_1", "N m s/rad", "N s/m", power=-2, open_low=False),
        "servo.position_gain": _motor("gain K_p of the servo on the position error", "N m/rad", "N/m", power=-2),
        "servo.velocity_gain": _motor("gain K_v on the speed error", "N m s/rad", "N s/m", power=-2, open_low=False),
        "servo.integral_gain": _motor(
            "gain K_i on the integral of the position error", "N m/(rad s)", "N/(m s)", power=-2, open_low=False
        ),
        "servo.control_dt": Rule(
            meaning="sample time of references and torques", shape=(), unit="s", low=0.0, open_low=True
        ),
        "sensors.encoder_bits": Rule(
            meaning="resolution of the measured motor position", shape=(), unit="bit/turn", side="motor", low=1.0
        ),
        "sensors.tracker_noise": Rule(
            meaning="standard deviation of each TCP coordinate that a tracker measures",
            shape=(),
            unit="m",
            low=0.0,
            optional=True,
        ),
        "sensors.tracker_period": Rule(
            meaning="sample time of the tracker", shape=(), unit="s", optional=True, low=0.0, open_low=True
        ),
        "simulation.physics_dt": Rule(
            meaning="physics step; divides control_dt", shape=(), unit="s", low=SHORTEST_STEP
        ),
        "simulation.gravity": Rule(meaning="gravity in the world", shape=(3,), unit="m/s^2"),
        "work_area.tool_rotation": Rule(
            meaning="orientation of tool0 in the world; without it the orientation is free",
            shape=(3, 3),
            unit="1",
            optional=True,
        ),
        "work_area.normal": Rule(
            meaning="normal of the plane of the test circles, any length; upright if left out",
            shape=(3,),
            unit="1",
            optional=True,
        ),
        "work_area.home": Rule(
            meaning="joint positions that seed the inverse kinematics",
            shape=("N",),
            unit="rad",
            side="link",
            optional=True,
            slide_unit="m",
        ),
    }
)
"""What a description must contain; optional entries may be left out."""

POINT = Rule(meaning="named point of the work area", shape=(3,), unit="m")
"""A named point of the work area."""

SPRING_RULES: Mapping[str, Rule] = MappingProxyType(
    {
        "start": Rule(meaning="point on the first body, in its frame", shape=(3,), unit="m"),
        "end": Rule(meaning="point on the second body, in its frame", shape=(3,), unit="m"),
        "length": Rule(meaning="length without force", shape=(), unit="m", low=0.0),
        "stiffness": Rule(meaning="stiffness k_1", shape=(), unit="N/m"),
        "stiffness_2": Rule(meaning="stiffness k_2", shape=(), unit="N/m^2", optional=True),
        "stiffness_3": Rule(meaning="stiffness k_3", shape=(), unit="N/m^3", optional=True),
    }
)
"""What a table [springs.<name>] must contain, beside the names of the bodies that it joins."""
