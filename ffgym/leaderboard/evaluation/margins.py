r"""Stability margins of an agent with feedback: how much more torque, and how late, its loop bears.

An agent with feedback adds torque from present errors of the motors to that of its base law, and so closes a loop
around the servo. Its own torque, the action less that of the base at the same observation, is multiplied by a factor,
or comes some samples later; base, servo and machine stay as they are.

**Criterion.** A loop is stable if its answer to a disturbance dies out while the robot moves. Two motions differ by a
short pulse of torque alone, which pushes all motors up in one and down in the other. The answer is the difference of
their motor errors,

.. math:: \delta(t) = e_+(t) - e_-(t)

and the loop is stable if on no motor its RMS in a window of the second half of the circle is as large as in the window
behind the pulse. Whatever both motions share cancels: reference, friction, and a correction that comes too large or too
late, which costs accuracy and is no instability. The torque of most agents is bounded, so that an unstable loop does
not diverge but chatters; two such oscillations that begin apart stay apart, and show here, too. Of a linear loop this
is the condition that its eigenvalues lie in the unit circle, but for what half a circle can tell from 1 (tests compare
them); of others it is the convergence of neighbouring motions, as in Demidovich's convergent systems.

Far beyond the border an oscillation may lock to the samples of the controller, and then pulses die out again. So the
smallest change with which a pulse stays ends the search, whatever comes behind it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ffgym.control import Policy, find_channel
from ffgym.control.observation import size_actions
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.envs.core import TrackingCore
from ffgym.leaderboard.evaluation.closed_loop import environment_for
from ffgym.leaderboard.plants import TestPlant
from ffgym.leaderboard.tasks import TRAIN_POSITION, Task

CIRCLES = (
    Task(TRAIN_POSITION, 0.010, (0.003,), "train"),
    Task(TRAIN_POSITION, 0.040, (0.005,), "train"),
    Task(TRAIN_POSITION, 0.100, (0.005,), "train"),
)
"""One circle at each speed of the thesis; chosen: as large as takes seconds, as an answer needs time to grow."""
PULSE = 0.3
"""Torque of the pulse in breakaway torques, at one sample; of set-points, position in f_s / K_p. Chosen: half the bound
of the residuals on the leaderboard, so that they answer it in full; an answer is some steps of a resolver then. What
half and twice of it find of three rows, mostly the same, is in docs/leaderboard/margins.md."""
WINDOW = 0.08
"""Window in which answers are compared [s]; chosen: a servo settles within it, and a lap has several."""
FACTORS = tuple(2.0**k for k in range(-4, 5))
"""Factors that are tried first; the largest is the limit of what is told."""
FINE = tuple(2.0 ** (k / 4) for k in (1, 2, 3))
"""Steps between two of them: a factor is told to 19 %."""
DELAYS = (1, 2, 4, 8, 16)
"""Delays that are tried first [samples of the controller], then all between two of them; the largest is the limit."""


@dataclass(frozen=True)
class Change:
    """Change of an agent's own torque."""

    factor: float = 1.0
    delay: int = 0
    """Samples of the controller by which it comes later."""


@dataclass(frozen=True, kw_only=True)
class LoopMargins:
    """Largest changes with which a loop is stable, each by itself, and so are all smaller ones that were tried."""

    gain: float
    """Largest factor; 0 if the smallest that is tried is too large, the largest of FACTORS if the loop bears all."""
    delay: int | None
    """Largest delay [samples of the controller]; None if the loop is unstable as it is."""


def measure_margins(
    plant: TestPlant,
    policy: Policy,
    base: Policy | None = None,
    *,
    circles: Sequence[Task] = CIRCLES,
    pulse: float = PULSE,
    n_threads: int = 0,
) -> LoopMargins:
    """Measure the margins of a policy on a machine.

    Args:
        plant: the machine.
        policy: policy of the track with feedback.
        base: policy of the law below it; None counts all of its torque as feedback.
        circles: motions, of one circle each.
        pulse: torque of the pulse in breakaway torques.
        n_threads: threads of the engine, 0 for all cores.

    Raises:
        FFGymError: if a policy does not fit the robot, or an action is not finite or has the wrong shape.
    """

    def stable(changes: Sequence[Change]) -> list[bool]:
        dies_out = find_stable(plant, policy, base, changes, circles=circles, pulse=pulse, n_threads=n_threads)
        return [bool(each.all()) for each in dies_out]

    return search_margins(stable)


def search_margins(stable: Callable[[Sequence[Change]], Sequence[bool]]) -> LoopMargins:
    """Search margins on a coarse grid, then between the last change that is borne and the first that is not.

    Args:
        stable: function that tells of each of some changes whether the loop is stable with it.
    """
    factors = [Change(factor=factor) for factor in FACTORS]
    most = _search(factors, lambda low, _: [replace(low, factor=low.factor * step) for step in FINE], stable)
    gain = 0.0 if most is None else most.factor
    if gain < 1.0:
        return LoopMargins(gain=gain, delay=None)
    delays = [Change(delay=delay) for delay in DELAYS]
    latest = _search(delays, lambda low, high: [Change(delay=k) for k in range(low.delay + 1, high.delay)], stable)
    return LoopMargins(gain=gain, delay=0 if latest is None else latest.delay)


def _search(
    coarse: Sequence[Change],
    refine: Callable[[Change, Change], list[Change]],
    stable: Callable[[Sequence[Change]], Sequence[bool]],
) -> Change | None:
    """Return the last change up to which all are borne; None if the first is not."""
    borne = _count_borne(stable(coarse))
    if borne in (0, len(coarse)):
        return coarse[-1] if borne else None
    finer = refine(coarse[borne - 1], coarse[borne])
    more = _count_borne(stable(finer)) if finer else 0
    return [coarse[borne - 1], *finer][more]


def _count_borne(stable: Sequence[bool]) -> int:
    """Count changes before the first with which the loop is unstable."""
    return int(np.argmin([*stable, False]))


def find_stable(
    plant: TestPlant,
    policy: Policy,
    base: Policy | None,
    changes: Sequence[Change],
    *,
    circles: Sequence[Task] = CIRCLES,
    pulse: float = PULSE,
    n_threads: int = 0,
) -> BoolArray:
    """Find out with which changes a loop is stable on each circle, all side by side; shape (C, circles).

    Arguments are those of `measure_margins`.
    """
    n = len(changes) * len(circles)
    preview = policy.preview if base is None else max(policy.preview, base.preview)
    env = environment_for(plant, preview, policy.action_scale, 2 * n, channel=find_channel(policy), n_threads=n_threads)
    core: TrackingCore = env.unwrapped.core
    each = [{"position": task.place, "speed": task.speed, "radii": task.radii} for task in circles]
    try:
        observation, _ = env.reset(seed=[0] * (2 * n), options={"each": each * len(changes) * 2})
        starts, ends = _circle_samples(core, n)
        errors, stopped = _run_pulses(env, policy, base, observation, changes, pulse, starts, ends)
    finally:
        env.close()
    # answers of the motors to the pulse, in windows from the pulse to the end of the circle
    answers = errors[:, :n] - errors[:, n:]
    window = round(WINDOW / core.robot.servo.control_dt)
    stable = [
        not stopped[[i, n + i]].any() and dies_out(answers[starts[i] + 1 : ends[i] + 1, i], window) for i in range(n)
    ]
    return np.array(stable, dtype=np.bool_).reshape(len(changes), len(circles))


def dies_out(answer: Array, window: int) -> bool:
    """Check that an answer (T, N) is smaller in all windows of its second half than in the first one, on each motor.

    Windows have so many samples, are counted from the end, and reach as far as the middle.
    """
    count = max(len(answer) // 2 // window, 1)
    late = answer[-count * window :].reshape(count, -1, answer.shape[1])
    first, rest = (np.sqrt(np.mean(np.square(part), axis=-2)) for part in (answer[:window], late))
    return bool(np.all(rest < first))


def _circle_samples(core: TrackingCore, n: int) -> tuple[IntArray, IntArray]:
    """Return first and last sample of the circle of the first `n` motions, shape (n,) each."""
    dt = core.robot.servo.control_dt
    phases = [motion.reference.phases for motion in core.motions[:n] if motion is not None]
    circles = [next(phase for phase in each if phase.kind == "circle") for each in phases]
    starts, ends = ([round(getattr(circle, side) / dt) for circle in circles] for side in ("start", "end"))
    return np.array(starts), np.array(ends)


def _run_pulses(
    env: Any,
    policy: Policy,
    base: Policy | None,
    observation: Array,
    changes: Sequence[Change],
    pulse: float,
    starts: IntArray,
    ends: IntArray,
) -> tuple[Array, BoolArray]:
    """Run motions with a pulse up (the first half) and down at `starts`, up to `ends`.

    Returns:
        Motor errors from the first sample on [rad], shape (T, 2 n, N), of fewer samples if all robots stop, and where
        the robot stopped, shape (2 n,).
    """
    core: TrackingCore = env.unwrapped.core
    robot, layout, rows = core.robot, core.observation_layout, np.arange(len(observation))
    agent, below = policy.agent(robot, layout), None if base is None else base.agent(robot, layout)
    # change and pulse of each row
    repeats = len(starts) // len(changes)
    factors, delays = (
        np.tile(np.repeat([getattr(change, name) for change in changes], repeats), 2) for name in ("factor", "delay")
    )
    push = pulse * size_actions(robot, 1.0, layout.channel) / core.action_size
    signs, at = np.repeat([1.0, -1.0], len(starts)), np.tile(starts, 2)
    # agent's own torque, the newest first, none before the motion
    past = np.zeros((delays.max() + 1, len(rows), robot.n_joints))
    state = below_state = None
    first = np.ones(len(rows), dtype=np.bool_)
    stopped, ended = np.zeros_like(first), np.zeros_like(first)
    errors = [core.signals.error]
    for k in range(int(ends.max())):
        action, state = agent.predict(observation, state, first, True)
        lower = np.zeros_like(action)
        if below is not None:
            lower, below_state = below.predict(observation, below_state, first, True)
        past = np.concatenate([(action - lower)[None], past[:-1]])
        own = factors[:, None] * past[delays, rows]
        observation, _, terminated, truncated, _ = env.step(lower + own + np.where(at == k, signs, 0.0)[:, None] * push)
        errors.append(core.signals.error)
        stopped |= terminated
        ended |= terminated | truncated
        if ended.all():
            break
        first[:] = False
    return np.stack(errors), stopped
