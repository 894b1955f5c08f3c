"""The engine of all environments: B sub-environments of one robot, stepped together, without automatic reset.

Everything a sub-environment computes is elementwise, or done by the engine one simulation at a time, so that its bits
do not depend on B, on its neighbours or on the number of threads.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

import mujoco
import numpy as np
from gymnasium import spaces

from ffgym.control.servo import servo_torque
from ffgym.control.setpoints import interpolate
from ffgym.envs.bank import MotionBank
from ffgym.envs.geometry import path_error
from ffgym.envs.motion import Columns, Motion
from ffgym.envs.observation import BOUND, ObservationLayout
from ffgym.envs.rewards import Reward, Signals, reward_of
from ffgym.envs.sensing import MotorSensors, Sensing
from ffgym.envs.settings import Settings, check_horizon, check_kind
from ffgym.envs.tasks import Tasks
from ffgym.errors import FFGymError, check_choice, check_whole
from ffgym.plant import Plant
from ffgym.recordings import PHASE_KINDS
from ffgym.robot import RobotDescription, robot_of
from ffgym.types import Array, BoolArray, IntArray

COMMON_OPTIONS = ("plant", "randomization", "reward", "sensing", "horizon")
"""What `reset(options=...)` may change for an episode in every environment."""
_POSITIONS = mujoco.mjtStage.mjSTAGE_POS.value
_PHASES = np.array(PHASE_KINDS)


@dataclass(frozen=True, kw_only=True, eq=False)
class Transition:
    """What a step brings in B sub-environments."""

    observation: Array
    """Shape (B, D)."""
    reward: Array
    """Shape (B,); 0 where nothing was stepped."""
    terminated: BoolArray
    """Emergency stop, shape (B,)."""
    truncated: BoolArray
    """End of the motion or of the horizon, shape (B,)."""


class Observer(Protocol):
    """Something that watches an engine, and leaves it as it is."""

    def begin(self, ids: IntArray) -> None:
        """Sub-environments `ids` have begun an episode."""

    def follow(self, ids: IntArray) -> None:
        """Sub-environments `ids` have done a control step."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Episode:
    """What an episode will be, checked."""

    motion: Motion
    robot: RobotDescription
    """The robot that is simulated."""
    last_step: int
    reward: Reward
    sensing: Sensing


class TrackingCore:
    """B robots that track motions under their existing controller, with torque added by an agent."""

    def __init__(self, tasks: Tasks, n: int, settings: Settings) -> None:
        self.n = n = check_whole("num_envs", n, low=1)
        self.tasks, self.settings, self.robot = tasks, settings, tasks.robot
        robot = self.robot
        self.plant_robot = robot if settings.plant is None else robot_of(settings.plant)
        """The robot that is simulated, before randomisation."""
        self.plant = Plant(self.plant_robot, n, n_threads=settings.n_threads)
        self.plant.check_controller(robot)
        self.action_scale = settings.action_torque(robot)
        self.observation_layout = ObservationLayout(robot, settings.preview, self.action_scale)
        self.observation_space: spaces.Box = spaces.Box(
            -BOUND, BOUND, shape=(self.observation_layout.size,), dtype=np.float64
        )
        self.action_space: spaces.Box = spaces.Box(-1.0, 1.0, shape=(robot.n_joints,), dtype=np.float32)
        self.decision_dt = robot.servo.control_dt
        self.columns = Columns(n_joints=robot.n_joints, has_tcp=robot.tool is not None)
        self._preview = self.observation_layout.preview
        self._width = max(self._preview + 1, 2)
        self._bank = MotionBank(n, self.columns, padding=self._width)
        self._fractions = np.arange(self.plant.n_substeps) / self.plant.n_substeps
        if self.columns.has_tcp:
            self._sites = self.plant.batch.bind("site_xpos")
            self._tcp_site = self.plant.model.site("tcp").id
        self._listed = tasks.listed() if settings.sampling == "sequence" else []
        if settings.sampling == "sequence" and not self._listed:
            raise FFGymError("sampling = 'sequence' needs motions that can be listed; random motions cannot.")
        self.observers: list[Observer] = []
        """Told of every episode that begins and of every control step, whatever layers are on top."""
        self._sensors = MotorSensors(n, robot.n_joints, robot.servo.control_dt)
        self._start_over(n, robot.n_joints)

    def _start_over(self, n: int, n_joints: int) -> None:
        """State before the first reset."""
        self.step_index: IntArray = np.zeros(n, dtype=np.int64)
        """Control steps done in the episode, shape (B,)."""
        self._last_step: IntArray = np.zeros(n, dtype=np.int64)
        self.action = np.zeros((n, n_joints))
        """Applied action, reached at the present sample, shape (B, N)."""
        self.tcp_offset = np.zeros((n, 3))
        """TCP - reference at the start of the episode [m], shape (B, 3)."""
        self._centre, self._normal = np.zeros((n, 3)), np.zeros((n, 3))
        self._rewards: list[Reward] = [reward_of(self.settings.reward, self.robot)] * n
        self._rngs: list[np.random.Generator | None] = [None] * n
        self._episodes: IntArray = np.zeros(n, dtype=np.int64)
        self.running: BoolArray = np.zeros(n, dtype=np.bool_)
        """Sub-environments in the middle of an episode, shape (B,)."""

    @property
    def motions(self) -> Sequence[Motion | None]:
        """What each sub-environment follows; None before its first reset."""
        return self._bank.motions

    @property
    def rows(self) -> Array:
        """Rows of the motions at the present sample, shape (B, W); `columns` says what stands where."""
        return self._window[:, 0]

    @property
    def time(self) -> Array:
        """Time in the episode [s], shape (B,)."""
        return np.multiply(self.step_index, self.robot.servo.control_dt)

    @property
    def rngs(self) -> Sequence[np.random.Generator | None]:
        """Randomness of each sub-environment; None before its first reset."""
        return self._rngs

    def seed(self, i: int, rng: np.random.Generator, fresh: bool) -> None:
        """Give a sub-environment its randomness; a `fresh` one begins the sequence of motions anew."""
        self._rngs[i] = rng
        if fresh:
            self._episodes[i] = 0

    def reset(self, ids: IntArray, options: Sequence[Mapping[str, Any]]) -> Array:
        """Begin episodes in sub-environments `ids`, with options for each; returns all observations, (B, D).

        Raises:
            FFGymError: if an option is unknown or not valid; within `all_or_nothing`, nothing has changed then.
        """
        for chosen in options:
            for name in chosen:
                check_choice("reset option", name, [*self.tasks.option_names, *COMMON_OPTIONS])
        if self.settings.recorder is not None:
            self.settings.recorder.claim(self)
        episodes = [self._draw(i, chosen) for i, chosen in zip(ids, options, strict=True)]
        self.plant.become(ids, [episode.robot for episode in episodes])
        self._rest(ids, [episode.motion for episode in episodes])
        for i, episode in zip(ids, episodes, strict=True):
            self._bank.assign(i, episode.motion)
            self._last_step[i], self._rewards[i] = episode.last_step, episode.reward
            self._sensors.set(i, episode.sensing)
            if self.columns.has_tcp:
                self._centre[i], self._normal[i] = episode.motion.plane
        self._episodes[ids] += 1
        fresh = np.zeros(self.n, dtype=np.bool_)
        fresh[ids] = True
        self._look(fresh)
        if self.settings.recorder is not None:
            self.settings.recorder.begin(self, ids)
        for observer in self.observers:
            observer.begin(ids)
        return self._observe()

    @contextmanager
    def all_or_nothing(self, ids: IntArray) -> Iterator[None]:
        """Where a `reset` of sub-environments `ids` fails, leave physics and randomness as they were."""
        robots, state = [self.plant.robots[i] for i in ids], self.plant.batch.state.copy()
        rngs, episodes = self._rngs.copy(), self._episodes.copy()
        drawn = [(rng.bit_generator, rng.bit_generator.state) for rng in rngs if rng is not None]
        try:
            yield
        except Exception:
            self.plant.become(ids, robots)
            self.plant.batch.state[:] = state
            self._rngs, self._episodes = rngs, episodes
            for bits, was in drawn:
                bits.state = was
            raise

    def _draw(self, i: int, options: Mapping[str, Any]) -> Episode:
        """The next episode; its motion is drawn first, then its plant."""
        rng = self._rngs[i]
        assert rng is not None  # the environment seeds before it resets
        horizon = check_horizon(options.get("horizon", self.settings.horizon))
        reward = reward_of(options.get("reward", self.settings.reward), self.robot)
        sensing = check_kind("sensing", options.get("sensing", self.settings.sensing))
        distribution = check_kind("randomization", options.get("randomization", self.settings.randomization))
        task = {name: value for name, value in options.items() if name in self.tasks.option_names}
        if self._listed:
            task = self._listed[int(i + self._episodes[i] * self.n) % len(self._listed)] | task
        motion = self.tasks.draw(rng, task)
        plant = robot_of(options["plant"]) if options.get("plant") is not None else self.plant_robot
        return Episode(
            motion=motion,
            robot=plant if distribution is None else distribution.draw(plant, rng),
            last_step=motion.n_steps if horizon is None else min(motion.n_steps, horizon),
            reward=reward,
            sensing=sensing,
        )

    def _rest(self, ids: IntArray, motions: Sequence[Motion]) -> None:
        """Put robots to the start of their motions, in equilibrium."""
        start = np.stack([motion.reference.q[0] for motion in motions])
        speed = np.stack([motion.reference.dq[0] for motion in motions])
        self.plant.rest(start, speed, ids)
        self.step_index[ids], self.action[ids], self.running[ids] = 0, 0.0, True
        if self.columns.has_tcp:
            self.plant.batch.forward(ids, stage=_POSITIONS)
            reference = np.stack([motion.arm.tcp_position(motion.reference.q[:1])[0] for motion in motions])
            self.tcp_offset[ids] = self._sites[ids, self._tcp_site] - reference

    def step(self, action: Array, active: BoolArray | None = None) -> Transition:
        """Add torque for one control step where `active`, shape (B,); elsewhere nothing moves. None is everywhere.

        The torque runs straight from the last action's to this one's, which it reaches at the end of the step.

        Args:
            action: shape (B, N); clipped to [-1, 1].
            active: which sub-environments.

        Raises:
            FFGymError: if an action is not finite, an episode has ended, or a simulation becomes unstable.
        """
        active = np.ones(self.n, dtype=np.bool_) if active is None else active
        ids = np.flatnonzero(active)
        action = self._checked(action, active)
        controls = self._controls(ids, action)
        every = None if len(ids) == self.n else ids
        recorder = self.settings.recorder
        if recorder is None:
            self.plant.drive(controls, every)
        else:
            recorder.add(self, ids, *self.plant.advance(controls, every), action[ids])
        if self.columns.has_tcp:
            self.plant.batch.forward(every, stage=_POSITIONS)
        self.action = np.where(active[:, None], action, self.action)
        self.step_index = self.step_index + active
        self._look(active)
        terminated = active & (np.abs(self.signals.error).max(axis=1) > self.settings.error_limit)
        truncated = active & (self.step_index >= self._last_step)
        self.running = self.running & ~(terminated | truncated)
        if recorder is not None:
            recorder.end(self, np.flatnonzero(terminated | truncated))
        for observer in self.observers:
            observer.follow(ids)
        reward = np.where(active, self._reward(terminated), 0.0)
        return Transition(observation=self._observe(), reward=reward, terminated=terminated, truncated=truncated)

    def _checked(self, action: Array, active: BoolArray) -> Array:
        """Action as it is applied."""
        values = np.asarray(action, dtype=np.float64)
        if values.shape != self.action.shape:
            raise FFGymError(f"action has shape {values.shape}, must be {self.action.shape}: sub-environments, motors.")
        if not np.isfinite(values[active]).all():
            i, j = (int(k) for k in np.argwhere(~np.isfinite(values) & active[:, None])[0])
            raise FFGymError(
                f"The action of sub-environment {i} for motor {self.robot.joints[j]} is {values[i, j]}, must be finite."
            )
        self.check_running(active)
        return np.clip(values, -1.0, 1.0)

    def check_running(self, active: BoolArray) -> None:
        """Raise if a sub-environment of `active` is not in the middle of an episode."""
        ended = np.flatnonzero(active & ~self.running)
        if ended.size:
            raise FFGymError(f"Sub-environments {ended.tolist()} have no episode running; call reset first.")

    def _controls(self, ids: IntArray, action: Array) -> Array:
        """MuJoCo's controls at every physics step of one control step, shape (B', S, 3 N)."""
        at, rows, added = self.columns, self._window[:, :2], np.stack([self.action, action], axis=1)
        if len(ids) < self.n:
            rows, added = rows[ids], added[ids]
        torque = rows[:, :, at.feedforward] + added * self.action_scale
        controls = np.empty((len(ids), 1, self.plant.n_substeps, self.plant.model.nu))
        out = self.plant.split_controls(controls)
        dt = self.robot.servo.control_dt
        interpolate(rows[:, :, at.position], rows[:, :, at.velocity], torque, dt, self._fractions, out)
        return controls[:, 0]

    def _look(self, fresh: BoolArray) -> None:
        """Take in the state after a step or a reset; sensors are sampled where it is `fresh`."""
        at = self.columns
        self._window = self._bank.window(self.step_index, self._width)
        now = self._window[:, 0]
        motor_position, motor_velocity, integral = self.plant.motor_state()
        error = now[:, at.position] - motor_position
        error_rate = now[:, at.velocity] - motor_velocity
        tcp = self._sites[:, self._tcp_site].copy() if at.has_tcp else None
        self.signals = Signals(
            error=error,
            error_rate=error_rate,
            feedback=servo_torque(self.robot.servo, error, error_rate, integral),
            action=self.action,
            tcp=tcp,
            path_error=None if tcp is None else path_error(tcp - self.tcp_offset, now, at, self._centre, self._normal),
        )
        first = fresh & (self.step_index == 0)
        angle, speed = self._sensors.read(motor_position, motor_velocity, self._rngs, fresh, first)
        self._seen = (now[:, at.position] - angle, now[:, at.velocity] - speed)

    def _observe(self) -> Array:
        """Observations, shape (B, D)."""
        window = self._window[:, : self._preview + 1, self.columns.reference]
        return self.observation_layout.encode(*self._seen, self.action, window)

    def _reward(self, stopped: BoolArray) -> Array:
        """Reward of the last step, shape (B,)."""
        if self._rewards.count(self._rewards[0]) == self.n:
            return self._rewards[0](self.signals, self.robot, stopped)
        rewards = {id(reward): reward for reward in self._rewards}
        each = {key: reward(self.signals, self.robot, stopped) for key, reward in rewards.items()}
        return np.array([each[id(reward)][i] for i, reward in enumerate(self._rewards)])

    def info(self) -> dict[str, Array]:
        """What the machine and its simulation know beside the observation, each of shape (B, ...), copies."""
        now, signals, at = self._window[:, 0], self.signals, self.columns
        out: dict[str, Array] = {
            "time": self.time,
            "u_c": signals.feedback.u_fb.copy(),
            "u_i": signals.feedback.u_i.copy(),
            "u_p": signals.feedback.u_p.copy(),
            "phase": _PHASES[now[:, at.phase].astype(np.int64)],
            "circle": now[:, at.circle].astype(np.int64),
        }
        if signals.tcp is not None and signals.path_error is not None:
            out |= {"tcp": signals.tcp.copy(), "path_error": signals.path_error.copy()}
        return out
