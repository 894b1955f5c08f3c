"""Questions by seed: what is hidden where, and how large; a new seed is a new exam."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from ffgym.core.errors import check_choice, check_whole
from ffgym.core.types import Array
from ffgym.effects import EFFECTS
from ffgym.effects.effect import Effect
from ffgym.robot import RigidArm, RobotDescription, load_robot
from ffgym.simulation.plant import Climate, Machine
from scripts.exam.calibration import current_offset, miscalibrated, reflector_offset
from scripts.exam.case import ROWS, Case, Row
from scripts.exam.equations import OUTSIDERS, VARIANTS, Variant
from scripts.exam.hidden import Hidden, drawn

ROBOT = "irb4600_60_205"
"""Robot of the exam: six axes, elastic joints, a laser tracker."""

QUIETEST, LOUDEST = 0.3, 1000.0
"""Energy that a hidden effect adds to the residual, in energies of the noise: least and most; log-uniform between."""

PAIR_QUIETEST = 15.0
"""Least for each of two effects, of which the demand is made above 10."""

AMBIENT, RISE, TIME_CONSTANT = 20.0, (19.0, 23.0), 900.0
"""Temperature of the room [degC], rise of joints in the end [K] and its time constant [s]; chosen: 5 to 20 min are
known of industrial robots, and 14 K come about in the quarter of an hour of a session."""

_NOT_HERE = ("link_clock",)
"""Effects that the robot cannot have: it has no encoders behind its gearboxes."""

PERIODIC: tuple[type[Effect], ...] = (
    EFFECTS["cogging"],
    EFFECTS["torque_ripple"],
    EFFECTS["kinematic_error"],
    EFFECTS["resolver_ripple"],
    VARIANTS["two_wave_cogging"],
    VARIANTS["two_wave_ripple"],
    VARIANTS["two_wave_gear_error"],
)
"""What repeats with the turn of a motor, by a number of cycles that an answer must give."""

COUNTS: Mapping[Row, int] = MappingProxyType(
    {
        "clean": 100,
        "single": 3 * (len(EFFECTS) - len(_NOT_HERE)),
        "foreign": 4 * len(VARIANTS),
        "outside": 3 * len(OUTSIDERS),
        "periodic": 2 * len(PERIODIC),
        "pair": 20,
        "poor": len(EFFECTS) - len(_NOT_HERE),
        "poor_clean": 16,
        "no_tracker": 16,
        "no_temperature": 16,
    }
)
"""Questions of a whole exam, by row."""

_LACKS: Mapping[Row, tuple[str, ...]] = MappingProxyType({"no_tracker": ("tcp",), "no_temperature": ("temperature",)})


def draw_case(row: Row, number: int, *, seed: int, arm: RigidArm | None = None) -> Case:
    """Question `number` of a row; it depends on nothing but these and the seed.

    Args:
        row: kind of question.
        number: from 0 on.
        seed: of the exam.
        arm: the nominal robot, if the caller has its dynamics already; None is that of the exam.

    Raises:
        FFGymError: if there is no such row, or a number is no whole number from 0 on.
    """
    check_choice("row of the exam", row, ROWS)
    key = (check_whole("seed", seed, low=0), ROWS.index(row), check_whole("number", number, low=0))
    rng = np.random.default_rng(key)
    arm = arm or RigidArm(load_robot(ROBOT))
    robot = arm.robot
    physical = miscalibrated(robot, rng)
    offset = current_offset(robot, rng)
    machine = Machine(robot=physical, effects=(reflector_offset(robot, rng),), climate=_climate(rng, robot.n_joints))
    hidden = _hidden(row, number, seed, physical, rng)
    return Case(
        row=row,
        number=number,
        arm=arm,
        machine=machine,
        current_offset=offset,
        hidden=hidden,
        loudness=_loudness(row, len(hidden), rng),
        noise=key,
        lacks=_LACKS.get(row, ()),
    )


def _climate(rng: np.random.Generator, n: int) -> Climate:
    rise: Array = rng.uniform(*RISE, size=n)
    return Climate(ambient=AMBIENT, rise=rise, time_constant=TIME_CONSTANT)


def _hidden(row: Row, number: int, seed: int, robot: RobotDescription, rng: np.random.Generator) -> tuple[Hidden, ...]:
    """What is hidden: kinds in an order by chance, so that as many questions as there are kinds have each once."""
    kinds = _kinds(row)
    if not kinds:
        return ()
    times, place = divmod(number, len(kinds))
    order = np.random.default_rng((seed, ROWS.index(row), 0, times)).permutation(len(kinds))
    first = drawn(kinds[order[place]], robot, rng)
    if row != "pair":
        return (first,)
    others = [kind for kind in kinds if _answer(kind) != first.answer]
    return first, drawn(others[rng.integers(len(others))], robot, rng)


def _kinds(row: Row) -> tuple[type[Effect], ...]:
    library = tuple(kind for name, kind in EFFECTS.items() if name not in _NOT_HERE)
    variants = tuple(VARIANTS.values())
    by_row: dict[Row, tuple[type[Effect], ...]] = {
        "clean": (),
        "poor_clean": (),
        "foreign": variants,
        "outside": tuple(OUTSIDERS.values()),
        "periodic": PERIODIC,
        "pair": (*library, *variants),
        "no_tracker": (*library, *variants),
        "no_temperature": (*library, *variants),
    }
    return by_row.get(row, library)


def _answer(kind: type[Effect]) -> str:
    """Name that a diagnosis should give to an effect of this kind."""
    return kind.variant_of if issubclass(kind, Variant) else kind.name


def _loudness(row: Row, count: int, rng: np.random.Generator) -> tuple[float, ...]:
    """How loud each effect is to be; those of a poor log are as large as they are plausible."""
    if row == "poor":
        return ()
    low = PAIR_QUIETEST if row == "pair" else QUIETEST
    return tuple((1 + np.exp(rng.uniform(np.log(low), np.log(LOUDEST), size=count))).tolist())
