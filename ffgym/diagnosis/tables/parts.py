"""Parts of structures by name: numbers of the description, friction of the law, and what the description lacks.

Priors of what effects bring are log-normal about a typical value within the range that the effect itself declares.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.types import Array
from ffgym.diagnosis.tables.structures import (
    CandidateModel,
    FreeNumber,
    ModelStructure,
    StructurePart,
    Values,
    combine,
    main_motors,
)
from ffgym.effects import Effect
from ffgym.effects.controller.servo_gains import ServoGains
from ffgym.effects.drive.delay import TorqueDelay
from ffgym.effects.transmission.backlash import Backlash
from ffgym.effects.transmission.base_flexibility import BaseFlexibility
from ffgym.effects.transmission.flexible_load import FlexibleLoad
from ffgym.effects.transmission.hysteresis import TorsionalHysteresis
from ffgym.effects.transmission.link_flexibility import LinkFlexibility

_LEVELS = ("coulomb", "static", "bristle_stiffness", "bristle_damping")
"""Parameters of LuGre friction that grow together with its level."""

_RATES = ("damping rate", "position bandwidth", "integral rate")
_SERVO = "order of magnitude known, a factor 2, as in scripts/calibrate_nominal.py"
_LEVEL = "friction levels of one type of robot differ by 30 % (Bittencourt 2012)"


def _main(candidate: CandidateModel, value: float) -> Array:
    """A number on the main motors, 0 on the others, shape (N,)."""
    return np.where(main_motors(candidate.robot), value, 0.0)


def _numbers(candidate: CandidateModel, values: Values) -> CandidateModel:
    """Servo rates of the main motors, stiffness of their joints, and levels of friction."""
    robot, main = candidate.robot, main_motors(candidate.robot)
    # gain = rate x the gain before it, see scripts/calibrate_nominal.py
    damping, bandwidth, integral = (values[f"{rate} of the main servos"] for rate in _RATES)
    gains = ServoGains(
        velocity=_main(candidate, damping - 1),
        position=_main(candidate, damping * bandwidth - 1),
        integral=_main(candidate, damping * bandwidth * integral - 1),
    )
    stiffness = np.ones(robot.n_joints)
    stiffness[:3] = [values[f"stiffness of joint {j}"] for j in range(1, 1 + len(stiffness[:3]))]
    drive = replace(
        robot.drive,
        joint_stiffness=robot.drive.joint_stiffness * stiffness,
        joint_damping=robot.drive.joint_damping * stiffness,
    )
    level = np.where(main, values["friction level, main"], values["friction level, wrist"])
    changed = replace(candidate, robot=replace(robot, drive=drive), effects=(*candidate.effects, gains))
    return changed.with_friction(**dict.fromkeys(_LEVELS, level), viscous=values["viscous friction"])


def _wrong_friction(candidate: CandidateModel, values: Values) -> CandidateModel:
    """Levels that the controller knows, relative to those of the machine."""
    level = values["friction level known over true"]
    factors = dict.fromkeys(_LEVELS, level)
    factors["bristle_stiffness"] = level * values["bristle stiffness known over true"]
    return replace(candidate, known=candidate.known.scale(**factors, viscous=values["viscous known over true"]))


def _arm_friction(candidate: CandidateModel, values: Values) -> CandidateModel:
    """One share behind the elasticity of the main joints; laws know the sum."""
    share = _main(candidate, values["share of friction behind the elasticity"])
    robot = candidate.robot.with_arm_share(share)
    return replace(candidate, robot=robot)


def _with_effect(candidate: CandidateModel, effect: Effect) -> CandidateModel:
    return replace(candidate, effects=(*candidate.effects, effect))


def _backlash(candidate: CandidateModel, values: Values) -> CandidateModel:
    gap = _main(candidate, values["half gap"])
    return _with_effect(candidate, Backlash(half_gap=gap))


def _hysteresis(candidate: CandidateModel, values: Values) -> CandidateModel:
    n = candidate.robot.n_joints
    return _with_effect(
        candidate,
        TorsionalHysteresis(
            lost_motion=_main(candidate, values["half the width of the loop"]),
            width=np.full(n, values["yield deflection"]),
        ),
    )


def _base(candidate: CandidateModel, values: Values) -> CandidateModel:
    tilt, turn = values["compliance of the base in tilt"], values["compliance of the base about its axis"]
    return _with_effect(candidate, BaseFlexibility(compliance=np.array([tilt, tilt, turn])))


def _delay(candidate: CandidateModel, values: Values) -> CandidateModel:
    n = candidate.robot.n_joints
    return _with_effect(candidate, TorqueDelay(delay=np.full(n, values["delay of the torque"]), lag=np.zeros(n)))


def _drive(candidate: CandidateModel, values: Values) -> CandidateModel:
    """Torque loop of all drives: dead time, lag, and a limit on the rate of its torque."""
    robot = candidate.robot
    ones = np.ones(robot.n_joints)
    drive = replace(
        robot.drive,
        torque_delay=values["dead time of the drive"] * ones,
        torque_lag=values["time constant of the torque loop"] * ones,
        torque_rate=robot.drive.peak_torque / values["time to peak torque"],
    )
    return replace(candidate, robot=replace(robot, drive=drive))


def _third_mass(candidate: CandidateModel, values: Values) -> CandidateModel:
    """Links of the first joints that bend behind their own mass."""
    compliance = np.zeros(candidate.robot.n_joints)
    compliance[:3] = [values[f"compliance of link {j}"] for j in range(1, 1 + len(compliance[:3]))]
    return _with_effect(candidate, LinkFlexibility(compliance=compliance))


def _flexible_load(candidate: CandidateModel, values: Values) -> CandidateModel:
    n = candidate.robot.n_joints
    effect = FlexibleLoad(
        inertia=_main(candidate, values["inertia of the third mass"]),
        frequency=np.full(n, values["frequency of the third mass"]),
        damping=np.full(n, values["damping of the third mass"]),
    )
    return _with_effect(candidate, effect)


def _servo_numbers() -> tuple[FreeNumber, ...]:
    return tuple(
        FreeNumber(name=f"{rate} of the main servos", typical=1.0, spread=0.7, source=_SERVO) for rate in _RATES
    )


NUMBERS = StructurePart(
    name="numbers",
    title="numbers of the description",
    numbers=(
        *_servo_numbers(),
        *(
            FreeNumber(
                name=f"stiffness of joint {j}",
                typical=1.0,
                spread=0.25,
                source="interpolated between published compliances, as in scripts/calibrate_nominal.py",
            )
            for j in (1, 2, 3)
        ),
        FreeNumber(name="friction level, main", typical=1.0, spread=0.3, source=_LEVEL),
        FreeNumber(name="friction level, wrist", typical=1.0, spread=0.3, source=_LEVEL),
        FreeNumber(
            name="viscous friction",
            typical=1.0,
            spread=0.8,
            source="known within a factor 5, read as two spreads (docs/robots/irb4600_60_205.md)",
        ),
    ),
    change=_numbers,
)
"""Numbers that any structure has free, as factors on the description as it is."""

_OLD = "levels of one robot drift by 30 % with temperature, load and wear (Bittencourt 2012)"

_LISTED = (
    NUMBERS,
    StructurePart(
        name="wrong_friction",
        title="wrong friction in the law",
        numbers=(
            FreeNumber(name="friction level known over true", typical=1.0, spread=0.3, source=_OLD),
            FreeNumber(name="viscous known over true", typical=1.0, spread=0.7, source="chosen: a factor 2"),
            FreeNumber(name="bristle stiffness known over true", typical=1.0, spread=0.7, source="chosen: a factor 2"),
        ),
        change=_wrong_friction,
    ),
    StructurePart(
        name="arm_friction",
        title="friction behind the elasticity",
        numbers=(
            FreeNumber(
                name="share of friction behind the elasticity",
                typical=0.5,
                spread=1.5,
                scale="share",
                source="90 % of friction is in the gearbox (thesis 4.1), and nobody says how much of that is behind "
                "its spring: nearly flat from 0.05 to 0.95",
            ),
        ),
        change=_arm_friction,
    ),
    StructurePart(
        name="delay",
        title="delay of the torque",
        numbers=(
            FreeNumber(
                name="delay of the torque",
                typical=5e-4,
                spread=0.7,
                unit="s",
                source="cycles of drives, 0.25 to 1 ms (effect torque_delay)",
            ),
        ),
        change=_delay,
    ),
    StructurePart(
        name="backlash",
        title="backlash",
        numbers=(
            FreeNumber(
                name="half gap",
                typical=3e-5,
                spread=1.0,
                unit="rad",
                source="up to 3e-4 rad when worn (effect backlash); a tenth is usual",
            ),
        ),
        change=_backlash,
    ),
    StructurePart(
        name="base_flexibility",
        title="flexibility of the base",
        numbers=(
            FreeNumber(
                name="compliance of the base in tilt",
                typical=6e-8,
                spread=1.0,
                unit="rad/(N m)",
                source="up to 3e-7 rad/(N m) (effect base_flexibility); a fifth is usual",
            ),
            FreeNumber(
                name="compliance of the base about its axis",
                typical=6e-8,
                spread=1.0,
                unit="rad/(N m)",
                source="as in tilt",
            ),
        ),
        change=_base,
    ),
    StructurePart(
        name="torsional_hysteresis",
        title="torsional hysteresis",
        numbers=(
            FreeNumber(
                name="half the width of the loop",
                typical=3e-5,
                spread=1.0,
                unit="rad",
                source="up to 1.5e-4 rad (effect torsional_hysteresis); a fifth is usual",
            ),
            FreeNumber(
                name="yield deflection",
                typical=3e-4,
                spread=0.5,
                unit="rad",
                source="1e-4 to 5e-4 rad (effect torsional_hysteresis)",
            ),
        ),
        change=_hysteresis,
    ),
    StructurePart(
        name="third_mass",
        title="third mass, links that bend",
        numbers=tuple(
            FreeNumber(
                name=f"compliance of link {j}",
                typical=2e-7,
                spread=1.0,
                unit="rad/(N m)",
                source="up to 1e-6 rad/(N m) (effect link_flexibility); a fifth is usual",
            )
            for j in (1, 2, 3)
        ),
        change=_third_mass,
    ),
    StructurePart(
        name="flexible_load",
        title="flexible load without weight",
        numbers=(
            FreeNumber(
                name="inertia of the third mass",
                typical=1.0,
                spread=1.0,
                unit="kg m^2",
                source="up to 2 kg m^2 (effect flexible_load)",
            ),
            FreeNumber(
                name="frequency of the third mass",
                typical=16.0,
                spread=0.4,
                unit="Hz",
                source="5 to 50 Hz, structural modes of industrial robots (effect flexible_load)",
            ),
            FreeNumber(
                name="damping of the third mass",
                typical=0.05,
                spread=0.7,
                source="1 to 20 % of critical damping (effect flexible_load)",
            ),
        ),
        change=_flexible_load,
    ),
    StructurePart(
        name="drive",
        title="drive with dead time, a torque loop of finite bandwidth and rate",
        numbers=(
            FreeNumber(
                name="dead time of the drive",
                typical=5e-4,
                spread=0.7,
                unit="s",
                source="1 to 2 cycles of a drive, 1e-4 to 1e-3 s (drive.torque_delay)",
            ),
            FreeNumber(
                name="time constant of the torque loop",
                typical=3e-4,
                spread=0.7,
                unit="s",
                source="1600 to 160 Hz (drive.torque_lag)",
            ),
            FreeNumber(
                name="time to peak torque",
                typical=1.6e-3,
                spread=0.7,
                unit="s",
                source="0.5 to 5 ms (drive.torque_rate)",
            ),
        ),
        change=_drive,
    ),
)

PARTS: Mapping[str, StructurePart] = {part.name: part for part in _LISTED}
"""Parts by name."""

SINGLE = ("description", *PARTS)
"""Structures of one part beside the numbers of the description, in the order of tables."""


def find_structure(name: str) -> ModelStructure:
    """Find a structure by its name, such as 'numbers', 'arm_friction' or 'arm_friction+delay'.

    Raises:
        FFGymError: if a part is unknown, or named twice.
    """
    if name == "description":
        return ModelStructure(parts=())
    names = [check_choice("structure", part, list(SINGLE)) for part in name.split("+")]
    if len(set(names)) < len(names) or "description" in names:
        raise FFGymError(f"Structure {name!r} must name different parts of {', '.join(PARTS)}.")
    return combine([NUMBERS, *(PARTS[part] for part in names if part != "numbers")])
