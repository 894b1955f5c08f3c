"""A machine under test: which robot, how it is driven, moved and measured; drawn by seed, without what is hidden."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from ffgym.core.types import Array
from ffgym.robot.description import RobotDescription
from scripts.exam.independent.arm import bodies_of, inverse_dynamics
from scripts.exam.independent.drive import Cascade, Contact, Continuous, Orders, Servo
from scripts.exam.independent.machine import Numbers, side_by_side, unsure
from scripts.exam.independent.motions import KINDS, motion
from scripts.exam.independent.plant import Plant
from scripts.exam.independent.robots import draw_robot
from scripts.exam.independent.sensors import NOISES, Columns, Exact, Noise, View, track

Control = Literal["documented", "cascade", "early"]
CONTROLS: tuple[Control, ...] = get_args(Control)
"""Controllers: that of the description; a cascade; that of the description along set-points that are logged early."""

STEP = 0.0005
"""Step of the integrator [s]; chosen: at half of it torques change by less than a hundredth of their noise."""

SETTLING = 0.4
"""Time before the log in which the arm comes to rest [s]; chosen: the slowest swing dies out."""

EARLY = 0.03
"""Time by which set-points are logged before the servo gets them [s]; chosen: interpolators of controllers."""

_PERIOD = 0.001
"""Sample time of the cascade [s]."""

SHARE = 0.005
"""Standard deviation of the numbers of a description, as a share of them: the default of a diagnosis."""

LOOSE = 0.05
"""The same where the description is typical."""

_OFFSET = 2.0
"""Standard deviation of the offsets of currents, as a share of Coulomb torque and of that of the numbers: as a
diagnosis believes."""

REFLECTOR = 20e-6
"""Standard deviation of the reflector's place, each axis [m]: as a diagnosis believes."""

_ROW_DT = (0.001, 0.002, 0.004, 0.005, 0.008, 0.01)
"""Sample periods of logs [s]: those of controllers between 1 kHz and 100 Hz."""

_LOGGED = (0.5, 0.5, 0.4, 0.5, 0.3)
"""Shares of logs with tracker, set-points, feedback, speeds and temperatures."""

_PAUSE = (20.0, 120.0)
"""Between motions [s]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Setup:
    """Machine, controller, motions and sensors of a log, without effects and without noise."""

    robot: RobotDescription
    """Description that the diagnosis gets."""
    share: float
    """Stated uncertainty of its numbers, as a share of them."""
    numbers: Numbers
    """True numbers of the machine."""
    control: Control
    columns: Columns
    noise: Noise
    row_dt: float
    motions: tuple[tuple[Array, Array, Array], ...]
    """Joint positions, speeds and accelerations at half steps, all of one length, shape (T, N) each."""
    started: Array
    """Start of the motions, on the clock of the session [s], shape (M,)."""
    warming: Array
    """Warming of the joints, beyond what the description holds for [K], shape (M, N)."""
    current_offset: Array
    """[N m], shape (N,)."""
    view: View
    """Pose of the tracker."""

    @property
    def label(self) -> str:
        """Conditions of the log, in words."""
        columns = [name for name in ("tracker", "set_points", "feedback") if getattr(self.columns, name)]
        kind = "rigid" if self.robot.drive.is_rigid.all() else "elastic"
        return ", ".join(
            [
                f"{self.robot.n_joints} axes {kind}",
                self.control,
                f"{self.row_dt * 1e3:g} ms",
                self.noise,
                f"numbers to {self.share:.1%}",
                *columns,
            ]
        )


def draw_setup(
    rng: np.random.Generator,
    *,
    n: int | None = None,
    elastic: bool | None = None,
    control: Control | None = None,
    columns: Columns | None = None,
    row_dt: float | None = None,
    noise: Noise | None = None,
    share: float | None = None,
    count: int = 6,
    duration: float = 4.0,
) -> Setup:
    """A machine of `n` joints by chance, with `count` motions of a `duration` [s]; what is given is not drawn."""
    n = int(rng.choice([1, 1, 2, 2, 3, 4, 6, 6, 7])) if n is None else n
    elastic = bool(rng.random() < 0.6) if elastic is None else elastic
    robot = draw_robot(n, elastic=elastic, rng=rng)
    share = float(rng.choice([SHARE, SHARE, SHARE, LOOSE])) if share is None else share
    reach = rng.uniform(0.25, 0.7, n) * (1.0 if n < 3 else 0.8)
    kinds = [*KINDS, *rng.choice(KINDS, size=max(0, count - len(KINDS)))][:count]
    where = np.zeros(n) if robot.work_area is None else robot.work_area.home
    motions = tuple(
        motion(kind, where, reach, 0.9 * robot.kinematics.max_speed, duration, STEP / 2, rng) for kind in kinds
    )
    started = np.cumsum(rng.uniform(*_PAUSE, size=count) + duration)
    rise = rng.uniform(3.0, 15.0, n)
    names = ("tracker", "set_points", "feedback", "speed", "temperature")
    return Setup(
        robot=robot,
        share=share,
        numbers=unsure(robot, share, rng),
        control=control or CONTROLS[int(rng.integers(len(CONTROLS)))],
        columns=columns or Columns(**dict(zip(names, (rng.random(5) < _LOGGED).tolist(), strict=True))),
        noise=noise or NOISES[int(rng.integers(len(NOISES)))],
        row_dt=float(rng.choice(_ROW_DT)) if row_dt is None else row_dt,
        motions=motions,
        started=started,
        warming=rise * (1 - np.exp(-started[:, None] / 600.0)),
        current_offset=_OFFSET * share * robot.friction.coulomb * rng.standard_normal(n),
        view=View(offset=REFLECTOR * rng.standard_normal(3)),
    )


def simulate_machines(setup: Setup, machines: list[tuple[Numbers, View]]) -> list[Exact]:
    """Simulate exact readings of machines in the place of that of a setup, in one run of the plant.

    Raises:
        FFGymError: if a machine becomes unstable.
    """
    count, copies = len(setup.motions), len(machines)
    numbers = side_by_side([one for one, _ in machines for _ in range(count)])
    q, dq, ddq = (np.stack([m[k] for m in setup.motions] * copies, axis=1) for k in range(3))
    before = 2 * round(SETTLING / STEP)
    orders = _orders(setup, q, dq, ddq, before)
    plant = Plant(
        numbers,
        Contact(stiffness=numbers.presliding, has_blocks=numbers.faults.get("blocks", np.zeros(numbers.shape)) > 0),
        _servo(setup, numbers.shape),
        dt=STEP,
        clock=np.tile(setup.started, copies) - SETTLING,
        warming=np.tile(setup.warming, (copies, 1)),
    )
    every = round(setup.row_dt / STEP)
    course = plant.run(q[0], orders, every)
    # what is logged begins when the arm has come to rest, and set-points may be seen before they come
    first = -(-before // (2 * every))
    rows = slice(2 * every * first, None, 2 * every)
    early = 2 * round(EARLY / STEP) if setup.control == "early" else 0
    shown = [
        np.concatenate([values[early:], np.repeat(values[-1:], early, axis=0)])[rows]
        for values in (orders.position, orders.speed)
    ]
    found = []
    for k, (machine, view) in enumerate(machines):
        own = slice(k * count, (k + 1) * count)
        angle = course.angle[first:, own]
        exact = Exact(
            dt=setup.row_dt,
            angle=angle,
            speed=course.speed[first:, own],
            torque=course.torque[first:, own],
            ahead=orders.ahead[rows][:, own],
            set_point=shown[0][:, own],
            set_speed=shown[1][:, own],
            tool=track(side_by_side([machine] * count).bodies, course.q[first:, own], view, setup.row_dt),
            temperature=np.broadcast_to(20.0 + setup.warming, angle.shape),
        )
        found.append(exact)
    return found


def _orders(setup: Setup, q: Array, dq: Array, ddq: Array, before: int) -> Orders:
    """Set-points and rigid feed-forward of what the description says, with a rest before."""
    robot, drive = setup.robot, setup.robot.drive
    coarse = round(2 * robot.servo.control_dt / STEP)
    rows = slice(None, None, coarse)  # as a controller computes it
    flat = [values[rows].reshape(-1, robot.n_joints) for values in (q, dq, ddq)]
    bodies = bodies_of(robot, len(flat[0]))
    rigid = inverse_dynamics(bodies, *flat).reshape(q[rows].shape)
    ahead = rigid / drive.gear_ratio + drive.gear_ratio * drive.rotor_inertia * ddq[rows]
    at = np.arange(len(q)) / coarse
    fine = np.stack(
        [np.interp(at, np.arange(len(ahead)), column) for column in ahead.reshape(len(ahead), -1).T], axis=1
    )
    ahead = fine.reshape(q.shape)
    if setup.control == "cascade":
        ahead = np.broadcast_to(ahead[:1], ahead.shape) * 0.0

    def rest(values: Array) -> Array:
        return np.concatenate([np.repeat(values[:1], before, axis=0), values])

    return Orders(position=rest(q * drive.gear_ratio), speed=rest(dq * drive.gear_ratio), ahead=rest(np.asarray(ahead)))


def _servo(setup: Setup, shape: tuple[int, int]) -> Servo:
    servo = setup.robot.servo
    gains = [np.broadcast_to(g, shape) for g in (servo.position_gain, servo.velocity_gain, servo.integral_gain)]
    if setup.control != "cascade":
        return Continuous(position=gains[0], speed=gains[1], integral=gains[2])
    return Cascade(
        rate=np.full(shape, 30.0),
        speed=0.8 * gains[1],
        reset=np.full(shape, 0.05),
        period=_PERIOD,
        steps_of_turn=2.0**20,
        corner=200.0,
        rise=0.0007,
        delay=1,
        share_ahead=0.9,
    )
