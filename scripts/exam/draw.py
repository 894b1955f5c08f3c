"""Questions by seed: what is hidden where, and how large, in a machine that differs from its description."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from types import MappingProxyType

import numpy as np

from ffgym.core.errors import check_choice, check_whole
from ffgym.core.types import Array
from ffgym.effects import EFFECTS
from ffgym.effects.effect import Effect
from ffgym.effects.measurement.tool_frame import ToolFrame
from ffgym.robot import RigidArm, RobotDescription, load_robot
from ffgym.simulation.plant import Climate, Machine
from scripts.exam.bench import Bench, usual_protocol
from scripts.exam.equations import OUTSIDERS, VARIANTS
from scripts.exam.hidden import Hidden, drawn
from scripts.exam.tasks import ROWS, Row

ROBOT = "irb4600_60_205"
"""Robot of the exam: six axes, elastic joints, a laser tracker."""

SPREAD = 0.005
"""Standard deviation of each number of a machine, as a share of it; chosen: a robot that was identified with care."""

TORQUE_OFFSET = 0.01
"""Standard deviation of the offset of current sensors, as a share of the Coulomb torque; chosen."""

TOOL_OFFSET = 15e-6
"""Standard deviation of the place of the reflector along each axis [m]; chosen: a fit of a few hundred positions."""

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
    *(EFFECTS[name] for name in ("cogging", "torque_ripple", "kinematic_error", "resolver_ripple")),
    *(VARIANTS[name] for name in ("two_wave_cogging", "two_wave_ripple", "two_wave_gear_error")),
)
"""Effects that repeat with the turn of a motor, by a number of cycles that an answer must give."""

_LIBRARY: tuple[type[Effect], ...] = tuple(kind for name, kind in EFFECTS.items() if name not in _NOT_HERE)

_ALL: tuple[type[Effect], ...] = (*_LIBRARY, *VARIANTS.values())

_ASKED: Mapping[Row, tuple[tuple[type[Effect], ...], int]] = MappingProxyType(
    {
        "clean": ((), 100),
        "single": (_LIBRARY, 3 * len(_LIBRARY)),
        "foreign": (tuple(VARIANTS.values()), 4 * len(VARIANTS)),
        "outside": (tuple(OUTSIDERS.values()), 3 * len(OUTSIDERS)),
        "periodic": (PERIODIC, 2 * len(PERIODIC)),
        "pair": (_ALL, 20),
        "poor": (_LIBRARY, len(_LIBRARY)),
        "poor_clean": ((), 16),
        "no_tracker": (_ALL, 16),
        "no_temperature": (_ALL, 16),
    }
)
"""Kinds of effects that are hidden, and number of questions, by row."""

COUNTS: Mapping[Row, int] = MappingProxyType({row: count for row, (_, count) in _ASKED.items()})
"""Questions of a whole exam, by row."""

_LACKS: Mapping[Row, tuple[str, ...]] = MappingProxyType({"no_tracker": ("tcp",), "no_temperature": ("temperature",)})


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """A machine whose model is wrong as models are, effects that may be hidden in it, and what is recorded of it."""

    row: Row
    number: int
    bench: Bench
    """Bench that records its log."""
    audible: Bench
    """Bench that loudness is computed on: with temperatures, as an effect is as loud without them."""
    machine: Machine
    """Machine with errors of calibration, but without what is hidden."""
    current_offset: Array
    """Offset of its current sensors, as torque, motor side [N m], shape (N,)."""
    hidden: tuple[Hidden, ...]
    """Effects, as large as they are plausible until they are sized."""
    loudness: tuple[float, ...]
    """Loudness that each is to have (`scripts.exam.loudness`); none leaves it as large as it is."""
    noise: tuple[int, ...]
    """Seed of the sensors' noise."""

    @property
    def robot(self) -> RobotDescription:
        """The nominal robot."""
        return self.bench.arm.robot

    @property
    def complete(self) -> Machine:
        """The machine with all that is hidden in it."""
        return replace(self.machine, effects=(*self.machine.effects, *(one.effect for one in self.hidden)))

    @property
    def is_poor(self) -> bool:
        """Tell whether its log is of small circles alone."""
        return self.row in ("poor", "poor_clean")

    def generator(self, *more: int) -> np.random.Generator:
        """Randomness of its own, another one for other numbers."""
        return np.random.default_rng((*self.noise, *more))


@cache
def bench_of_exam(arm: RigidArm, poor: bool, lacks: tuple[str, ...]) -> Bench:
    """Bench of the exam, made once."""
    return Bench(arm=arm, protocols=(usual_protocol(arm, poor=poor),), lacks=lacks)


def draw_case(row: Row, number: int, *, seed: int, arm: RigidArm | None = None) -> Case:
    """Question `number` of a row, which these and the seed decide alone.

    A caller that has the dynamics of the nominal robot already gives its `arm`.

    Raises:
        FFGymError: if there is no such row, or a number is no whole number from 0 on.
    """
    check_choice("row of the exam", row, list(_ASKED))
    key = (check_whole("seed", seed, low=0), ROWS.index(row), check_whole("number", number, low=0))
    rng = np.random.default_rng(key)
    arm = arm or RigidArm(load_robot(ROBOT))
    machine, offset = draw_machine(arm.robot, rng)
    hidden = _hidden(row, number, seed, machine.robot, rng)
    loudness: tuple[float, ...] = ()  # effects of a poor log are as large as they are plausible
    if row != "poor":
        low = PAIR_QUIETEST if row == "pair" else QUIETEST
        loudness = tuple((1 + np.exp(rng.uniform(np.log(low), np.log(LOUDEST), size=len(hidden)))).tolist())
    lacks, poor = _LACKS.get(row, ()), row in ("poor", "poor_clean")
    return Case(
        row=row,
        number=number,
        bench=bench_of_exam(arm, poor, lacks),
        audible=bench_of_exam(arm, poor, tuple(family for family in lacks if family != "temperature")),
        machine=machine,
        current_offset=offset,
        hidden=hidden,
        loudness=loudness,
        noise=key,
    )


def draw_machine(robot: RobotDescription, rng: np.random.Generator) -> tuple[Machine, Array]:
    """A machine as its description is wrong of one, and the offset of its current sensors [N m], shape (N,)."""
    physical = miscalibrate(robot, rng)
    offset = TORQUE_OFFSET * robot.friction.coulomb * rng.standard_normal(robot.n_joints)
    reflector = ToolFrame.on(robot, offset=TOOL_OFFSET * rng.standard_normal(3))
    rise: Array = rng.uniform(*RISE, size=robot.n_joints)
    climate = Climate(ambient=AMBIENT, rise=rise, time_constant=TIME_CONSTANT)
    return Machine(robot=physical, effects=(reflector,), climate=climate), offset


def miscalibrate(robot: RobotDescription, rng: np.random.Generator) -> RobotDescription:
    """A robot like `robot` whose masses, rotors, friction, stiffness and damping all are a little different."""

    def off(*shape: int) -> Array:
        return 1 + SPREAD * rng.standard_normal(shape)

    n = robot.n_joints
    drive, bodies = robot.drive, robot.bodies
    names = ("coulomb", "static", "viscous", "stribeck_velocity", "bristle_stiffness", "bristle_damping")
    friction = {name: getattr(robot.friction, name) * off(n) for name in names}
    friction["static"] = np.maximum(friction["static"], friction["coulomb"])
    return replace(
        robot,
        friction=replace(robot.friction, **friction),
        drive=replace(
            drive,
            rotor_inertia=drive.rotor_inertia * off(n),
            joint_stiffness=drive.joint_stiffness * off(n),
            joint_damping=drive.joint_damping * off(n),
        ),
        bodies=replace(bodies, mass=bodies.mass * off(n), inertia=bodies.inertia * off(n, 1)),
        quantities=MappingProxyType({}),  # origins of the numbers that were just changed
    )


def errors_beside(hidden: Hidden, described: RobotDescription, machine: Machine, offset: Array) -> dict[str, float]:
    """Compute what errors of the description add to the numbers of an effect, by their names.

    One number of the machine is off by both, and they cannot be told apart. The machine is that of the log, without
    the effect; `offset` is that of its current sensors, as torque, motor side [N m], shape (N,).
    """
    parameters, found = hidden.effect.parameters(), dict[str, float]()
    for name, value in hidden.numbers(described).items():
        known = parameters.get(name)  # none for one part of a vector
        if value and known is not None and (number := known.of):
            true, nominal = (getattr(getattr(robot, number[0]), number[1]) for robot in (machine.robot, described))
            j = described.joints.index(hidden.joint)
            found[name] = float((true[j] / nominal[j] - 1) * (1 + value))
    if hidden.effect.name == "torque_offset":
        found["offset"] = -float(offset[described.joints.index(hidden.joint)])  # the current says so much more
    for other in machine.effects:
        if other.name == hidden.effect.name:  # the reflector, the only effect that all machines have
            found |= Hidden(effect=other, joint=hidden.joint).numbers(described)
    return found


def _hidden(row: Row, number: int, seed: int, robot: RobotDescription, rng: np.random.Generator) -> tuple[Hidden, ...]:
    """Draw hidden effects: kinds in an order by chance, so that as many questions as there are kinds have each once."""
    kinds, _ = _ASKED[row]
    if not kinds:
        return ()
    times, place = divmod(number, len(kinds))
    order = np.random.default_rng((seed, ROWS.index(row), 0, times)).permutation(len(kinds))
    first = drawn(kinds[order[place]], robot, rng)
    if row != "pair":
        return (first,)
    others = [kind for kind in kinds if getattr(kind, "variant_of", kind.name) != first.answer]
    return first, drawn(others[rng.integers(len(others))], robot, rng)
