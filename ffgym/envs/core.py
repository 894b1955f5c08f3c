"""The engine of all environments: B sub-environments of one robot, stepped together, without automatic reset.

Everything a sub-environment computes is elementwise, a sum within its row, or done by the engine one simulation at a
time, so that its bits do not depend on B, on its neighbours or on the number of threads.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import mujoco
import numpy as np
from gymnasium import spaces

from ffgym.control.observation import BOUND, ObservationLayout, Scales
from ffgym.control.setpoints import interpolate_motion, join_torques, servo_torque
from ffgym.core.errors import FFGymError, check_whole
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.envs.bank import MotionBank, path_error
from ffgym.envs.bases import find_base
from ffgym.envs.corrections import Corrections
from ffgym.envs.motion import EpisodeMotion, MotionColumns
from ffgym.envs.rewards import Reward, RewardSignals, find_reward, mean_square
from ffgym.envs.settings import EnvSettings
from ffgym.envs.start import Starts
from ffgym.envs.tasks import MotorSensors, Observer, Tasks, Transition, copy_changing, restore_changing
from ffgym.recordings import PHASE_KINDS
from ffgym.robot.parts import Servo
from ffgym.simulation.plant import Plant

_POSITIONS = mujoco.mjtStage.mjSTAGE_POS.value
_PHASES = np.array(PHASE_KINDS)


WINDOW = 2
"""Rows of the motions that are looked up in each step: the present sample and the next one."""
_ENDLESS = 2**62
"""Control steps of an episode without horizon."""

_CHANGING = (
    "step_index",
    "_last_step",
    "_left",
    "_to_come",
    "_practice",
    "action",
    "clipped",
    "_mean_square",
    "_circle",
    "tcp_offset",
    "_rewards",
    "_one_reward",
    "_scores",
    "_running",
    "_in_step",
    "_labels",
    "_rows",
    "_seen",
    "signals",
)
"""Attributes of the core that steps and resets change, beside those of its parts."""


class TrackingCore:
    """B robots that track motions under their existing controller, with torque added by an agent."""

    def __init__(self, tasks: Tasks, n: int, settings: EnvSettings) -> None:
        self.n = n = check_whole("num_envs", n, low=1)
        self.tasks, self.settings, self.robot = tasks, settings, tasks.robot
        robot = self.robot
        self.starts = Starts(tasks, n, settings)
        self.plant = Plant(self.starts.machines[0], n, n_threads=settings.n_threads)
        self.plant.check_controller(robot)
        # spaces of observations and actions
        self.action_size = settings.action_size(robot)
        """What an action of 1 adds, motor side: torque [N m], or position of the set-point [rad], shape (N,)."""
        self.observation_layout = layout = ObservationLayout(
            robot,
            settings.preview,
            self.action_size,
            channel=settings.channel,
            sees_errors=settings.track == "feedback",
            features=settings.features,
        )
        self.observation_space: spaces.Box = spaces.Box(-BOUND, BOUND, shape=(layout.size,), dtype=np.float64)
        self.action_space: spaces.Box = spaces.Box(-1.0, 1.0, shape=(robot.n_joints,), dtype=np.float32)
        self.decision_dt = robot.servo.control_dt
        self.columns = MotionColumns(n_joints=robot.n_joints, has_tcp=robot.tool is not None)
        # numbers with a row for each robot, as arrays of one shape are multiplied faster
        self._error_scale = Scales.of(robot).error
        self._action_sizes = np.tile(self.action_size, (n, 1))
        self._servos = _tile_gains(robot.servo, n)
        self._action_bounds = np.full((n, robot.n_joints), -1.0), np.full((n, robot.n_joints), 1.0)
        self._error_limits = np.full((n, robot.n_joints), settings.error_limit)
        self._controls_buffer = np.zeros((n, self.plant.n_substeps, self.plant.model.nu))
        self._torques_buffer = self.plant.split_controls(self._controls_buffer)[2].swapaxes(1, 2)
        """The torques among the controls, (B, N, S)."""
        # instants of physics steps within a control step
        self._fractions = np.arange(self.plant.n_substeps) / self.plant.n_substeps
        self.base = find_base(settings.base, robot)
        """Law whose torque is added beside the action; None for none."""
        self.corrections = Corrections(self.plant) if settings.channel == "setpoint" else None
        """Corrections of set-points; None if actions and base are torques."""
        self._bank = MotionBank(n, self.columns, max(layout.preview + 1, WINDOW), self.plant, self.base, layout)
        if self.columns.has_tcp:
            self._sites = self.plant.batch.bind("site_xpos")
            self._tcp_site = self.plant.model.site("tcp").id
        self.observers: list[Observer] = []
        """Observers, called when episodes begin and after every control step, whatever layers are on top."""
        self._sensors = MotorSensors(n, robot.n_joints, robot.servo.control_dt)
        self._start_over(n, robot.n_joints)

    def _start_over(self, n: int, n_joints: int) -> None:
        """Set the state before the first reset."""
        self.step_index: IntArray = np.zeros(n, dtype=np.int64)
        """Control steps done in the episode, shape (B,)."""
        self._last_step: IntArray = np.zeros(n, dtype=np.int64)
        self.action = np.zeros((n, n_joints))
        """Applied action, reached at the present sample, shape (B, N)."""
        self.clipped: BoolArray = np.zeros((n, n_joints), dtype=np.bool_)
        """True where the last action was beyond its limits and was clipped, shape (B, N)."""
        self._mean_square = np.zeros(n)
        """Mean square of the scored error over the circle so far, shape (B,), see `RewardSignals`."""
        self._circle: Array = np.full(n, -1.0)
        self._left: IntArray = np.zeros(n, dtype=np.int64)
        """Control steps that are left for motions to come, shape (B,)."""
        self._to_come: list[tuple[EpisodeMotion, ...]] = [()] * n
        """Motions to come in each episode."""
        self._practice: BoolArray = np.zeros(n, dtype=np.bool_)
        """True in a motion that is not rewarded, shape (B,)."""
        self.tcp_offset = np.zeros((n, 3))
        """TCP - reference at the start of the episode [m], shape (B, 3)."""
        self._rewards: list[Reward] = [find_reward(self.settings.reward, self.robot)] * n
        self._one_reward = True
        self._scores = self._rewards[0].uses_mean_square
        self._touched = False
        self._running: BoolArray = np.zeros(n, dtype=np.bool_)
        self._in_step = True
        """True if the last step came to its end, so that engine and counters agree."""

    @property
    def motions(self) -> Sequence[EpisodeMotion | None]:
        """Motion of each sub-environment; None before its first reset."""
        return self._bank.motions

    @property
    def running(self) -> BoolArray:
        """Sub-environments in the middle of an episode, shape (B,); none after a step that failed on its way."""
        return self._running if self._in_step else np.zeros_like(self._running)

    @property
    def rows(self) -> Array:
        """Rows of the motions at the present sample, shape (B, W), by `columns`."""
        return self._rows

    @property
    def time(self) -> Array:
        """Time in the episode [s], shape (B,)."""
        return np.multiply(self.step_index, self.robot.servo.control_dt)

    def reset(self, ids: IntArray, options: Sequence[Mapping[str, Any]]) -> Array:
        """Begin episodes in sub-environments `ids`, with options for each; returns all observations, (B, D)."""
        recorder = self.settings.recorder
        if recorder is not None:
            recorder.claim(self)
        # draw the episodes, and put the plant to their starts
        starts = self.starts.draw(ids, options)
        self.plant.become(ids, [start.machine for start in starts])
        for i, start in zip(ids, starts, strict=True):
            self._left[i] = _ENDLESS if start.horizon is None else start.horizon
            self._to_come[i] = start.then
        self._begin_motions(ids, [start.motion for start in starts])
        # reward and sensors of each episode
        for i, start in zip(ids, starts, strict=True):
            self._rewards[i] = start.reward
            self._sensors.set(i, start.sensing, start.noise)
        self._one_reward = len({id(reward) for reward in self._rewards}) == 1
        self._scores = any(reward.uses_mean_square for reward in self._rewards)
        self._look_first(ids)
        return self._observe()

    def _begin_motions(self, ids: IntArray, motions: Sequence[EpisodeMotion]) -> None:
        """Put sub-environments `ids` to rest at the start of motions, which they follow from now on."""
        references = [motion.reference for motion in motions]
        self.plant.rest(np.stack([r.q[0] for r in references]), np.stack([r.dq[0] for r in references]), ids)
        self._touched = True
        self._rest(ids, motions)
        for i, motion in zip(ids, motions, strict=True):
            self._bank.assign(i, motion)
            self._last_step[i] = min(motion.n_steps, self._left[i])
            self._left[i] -= self._last_step[i]
            self._practice[i] = motion.is_practice
        self._labels = np.array([str(motion.label) if motion else "" for motion in self.motions])

    def _look_first(self, ids: IntArray) -> None:
        """Read the state at the start of motions of sub-environments `ids`, and tell recorder and observers."""
        fresh = np.zeros(self.n, dtype=np.bool_)
        fresh[ids] = True
        self._look(fresh)
        if self.settings.recorder is not None:
            self.settings.recorder.begin(self, ids)
        for observer in self.observers:
            observer.begin(ids)

    def _find_unfinished(self, truncated: BoolArray, terminated: BoolArray) -> BoolArray:
        """Find where a motion has ended that is not the last of its episode, shape (B,)."""
        if not truncated.any() or not any(self._to_come):
            return np.zeros_like(truncated)
        more = np.array([bool(motions) for motions in self._to_come]) & (self._left > 0)
        unfinished: BoolArray = truncated & ~terminated & more
        return unfinished

    def _go_on(self, ids: IntArray) -> None:
        """Begin the next motion of the episodes of sub-environments `ids`, on the same machines."""
        motions = [self._to_come[i][0] for i in ids]
        for i in ids:
            self._to_come[i] = self._to_come[i][1:]
        self._begin_motions(ids, motions)
        self._look_first(ids)

    def save(self) -> list[dict[str, Any]]:
        """Copy all that steps and resets change.

        Raises:
            FFGymError: if episodes are recorded: a recording cannot go back.
        """
        if self.settings.recorder is not None:
            raise FFGymError(
                "The state cannot be taken while episodes are recorded; make an environment without recorder."
            )
        own = copy_changing(self, _CHANGING)
        parts = {"plant": self.plant.save(), "starts": self.starts.save(), "sensors": self._sensors.save()}
        if self.corrections is not None:
            parts["corrections"] = self.corrections.save()
        return [own | {"motions": list(self.motions), **parts}]

    def restore(self, saved: Sequence[Mapping[str, Any]]) -> None:
        """Go back to what `save` copied, to the bit."""
        own = dict(saved[0])
        self.plant.restore(own.pop("plant"))
        restore_changing(self.starts, own.pop("starts"))
        self._sensors.restore(own.pop("sensors"))
        if self.corrections is not None:
            self.corrections.restore(own.pop("corrections"))
        for i, motion in enumerate(own.pop("motions")):
            if motion is not None:
                self._bank.assign(i, motion)
        restore_changing(self, own)
        self._find_places()
        if self.columns.has_tcp:  # which pictures show
            self.plant.batch.forward(None, stage=_POSITIONS)

    @contextmanager
    def all_or_nothing(self, ids: IntArray) -> Iterator[None]:
        """Leave physics and randomness as they were if a `reset` of sub-environments `ids` fails.

        If it fails after the engine has begun the new episodes (in a layer, or by Ctrl-C), they wait for another reset.
        """
        saved = self.plant.save()
        self._touched = False
        try:
            with self.starts.all_or_nothing():
                yield
        except BaseException:
            self.plant.restore(saved)
            if self._touched:
                self._running[ids] = False
                self._find_places()
            raise

    def _rest(self, ids: IntArray, motions: Sequence[EpisodeMotion]) -> None:
        """Put robots to the start of their motions, in equilibrium."""
        self._running, self._in_step = self.running, True
        self.step_index[ids], self.action[ids], self._running[ids] = 0, 0.0, True
        self.clipped[ids] = False
        if self.corrections is not None:
            self.corrections.rest(ids)
        if self.columns.has_tcp:
            self.plant.batch.forward(ids, stage=_POSITIONS)
            reference = np.stack([motion.arm.tcp_position(motion.reference.q[:1])[0] for motion in motions])
            self.tcp_offset[ids] = self._sites[ids, self._tcp_site] - reference

    def step(self, action: Array, active: BoolArray | None = None) -> Transition:
        """Add torque for one control step where `active`, shape (B,); elsewhere nothing moves. None is everywhere.

        The torque runs straight from the last action's to this one's, which it reaches at the end of the step.

        Args:
            action: finite, shape (B, N); clipped to [-1, 1].
            active: sub-environments to step, all in the middle of an episode.

        Raises:
            FFGymError: if a simulation becomes unstable.
        """
        if active is not None and active.all():
            active = None
        low, high = self._action_bounds
        wanted, action = action, np.minimum(np.maximum(action, low), high)
        clipped = wanted != action
        # move, and count the step
        self._in_step = False  # until engine and counters agree again
        self._move(action, None if active is None else np.flatnonzero(active))
        if active is None:
            self.action, self.clipped, self.step_index = action, clipped, self.step_index + 1
        else:
            self.action = np.where(active[:, None], action, self.action)
            self.clipped = np.where(active[:, None], clipped, self.clipped)
            self.step_index = self.step_index + active
        # ends and reward
        self._look(active)
        beyond = np.abs(self.signals.error) > self._error_limits
        terminated: BoolArray = np.zeros(self.n, dtype=np.bool_)
        if np.count_nonzero(beyond):
            terminated = np.logical_or.reduce(beyond, axis=1)
        truncated: BoolArray = self.step_index >= self._last_step
        reward = self._reward(terminated)
        if np.count_nonzero(self._practice):  # which costs nothing but a stop
            reward = np.where(self._practice & ~terminated, 0.0, reward)
        if active is not None:
            terminated, truncated, reward = terminated & active, truncated & active, np.where(active, reward, 0.0)
        # motions that have ended, and episodes but for those that go on with another motion
        done = terminated | truncated
        any_done = np.count_nonzero(done) > 0
        goes_on = self._find_unfinished(truncated, terminated) if any_done else done
        if any_done:
            self._running = self._running & ~(done & ~goes_on)
            if self.settings.recorder is not None:
                self.settings.recorder.end(self, np.flatnonzero(done))
        # observers, which change nothing
        for observer in self.observers:
            observer.follow(np.arange(self.n) if active is None else np.flatnonzero(active))
        self._in_step = True
        if np.count_nonzero(goes_on):
            self._go_on(np.flatnonzero(goes_on))
            truncated = truncated & ~goes_on
        return Transition(observation=self._observe(), reward=reward, terminated=terminated, truncated=truncated)

    def _move(self, action: Array, ids: IntArray | None) -> None:
        """Let the engine run sub-environments `ids` for one control step; None is all."""
        controls, recorder = self._controls(action, ids), self.settings.recorder
        if recorder is None:
            self.plant.drive(controls, ids)
        else:
            moved = np.arange(self.n) if ids is None else ids
            recorder.add(self, moved, self.plant.advance_with_readings(controls, ids), action[moved])
        if self.columns.has_tcp:
            self.plant.batch.forward(ids, stage=_POSITIONS)

    def _controls(self, action: Array, ids: IntArray | None) -> Array:
        """Compute MuJoCo's controls at every physics step of one control step, shape (B', S, 3 N)."""
        places, last, per_action = self._places, self.action, self._action_sizes
        if ids is not None:
            places, last, action, per_action = places[:, ids], last[ids], action[ids], per_action[ids]
        # feed-forward plus added torque at both ends of the step
        start, end = self._bank.torques(places[:WINDOW])
        if self.corrections is None:
            start += last * per_action
            end += action * per_action
        # set-points, kept or interpolated
        controls, torques = self._controls_buffer[: len(last)], self._torques_buffer[: len(last)]
        if not self._bank.write_setpoints(places[0], controls):
            position, velocity, _ = self.plant.split_controls(controls[:, None])
            at, rows = self.columns, self._bank.rows(places[:WINDOW]).swapaxes(0, 1)
            samples = rows[:, :, at.position], rows[:, :, at.velocity]
            interpolate_motion(*samples, self.robot.servo.control_dt, self._fractions, (position, velocity))
        join_torques(start, end, self._fractions, torques)
        if self.corrections is not None:
            following = self.compute_added(action, slice(None) if ids is None else ids)
            self.corrections.advance(ids, following, controls)
        return controls

    def compute_added(self, action: Array, ids: IntArray | slice) -> Array:
        """Compute what base and actions (B', N) add at the next sample of `ids`, as `action_size`, motor side."""
        return action * self.action_size + self._next_base(ids)

    def _next_base(self, ids: IntArray | slice) -> Array:
        """Look up what the base adds at the next sample of `ids`, as `action_size`, motor side, (B', N)."""
        return self._bank.rows(self._places[1, ids])[:, self.columns.base]

    def _find_places(self) -> None:
        """Find the rows of the motions from the present sample on."""
        self._places = self._bank.places(self.step_index, max(self.observation_layout.preview + 1, WINDOW))

    def _look(self, fresh: BoolArray | None) -> None:
        """Read the state after a step or a reset; sensors are sampled where it is `fresh`, None is everywhere."""
        # error of the servos
        at = self.columns
        self._find_places()
        self._rows = now = self._bank.rows(self._places[0])
        angle, speed, integral = self.plant.servo_state()
        error, error_rate = now[:, at.position] - angle, now[:, at.velocity] - speed
        # true signals, for rewards and info
        tcp = self._sites[:, self._tcp_site].copy() if at.has_tcp else None
        away = None if tcp is None else path_error(tcp - self.tcp_offset, now, at, has_bends=self._bank.has_bends)
        before, after = self._score(error, away, fresh) if self._scores else (None, None)
        followed = (error, error_rate)  # of the set-points that servos follow
        if self.corrections is not None:
            followed = error + self.corrections.position, error_rate + self.corrections.speed
        self.signals = RewardSignals(
            error=error,
            error_rate=error_rate,
            feedback=servo_torque(self._servos, *followed, integral),
            action=self.action,
            tcp=tcp,
            path_error=away,
            mean_square_before=before,
            mean_square=after,
        )
        # error that sensors measure, for observations
        if self._sensors.exact:
            self._seen = (error, error_rate)
            return
        angle, speed = self._sensors.read(angle, speed, fresh, self.step_index == 0)
        self._seen = (now[:, at.position] - angle, now[:, at.velocity] - speed)

    def _score(self, error: Array, away: Array | None, fresh: BoolArray | None) -> tuple[Array, Array]:
        """Add the present error to the mean square over its circle; return it before and after, shape (B,) each.

        Args:
            error: of the motors [rad], shape (B, N), scored by a robot without tool.
            away: distance of the TCP from its path [m], shape (B,); None for a robot without tool.
            fresh: where there is a new sample, shape (B,); None is everywhere.
        """
        now, at = self._rows, self.columns
        square = np.square(away) if away is not None else mean_square(error / self._error_scale)
        # a circle begins with the first sample of another number, and an episode with its first sample
        circle, share = now[:, at.circle], now[:, at.share]
        begins = (circle != self._circle) | (self.step_index == 0)
        before = np.where(begins, 0.0, self._mean_square)
        after = before + share * square
        self._mean_square = after if fresh is None else np.where(fresh, after, self._mean_square)
        self._circle = circle if fresh is None else np.where(fresh, circle, self._circle)
        return before, after

    def _observe(self) -> Array:
        """Encode observations, shape (B, D)."""
        layout = self.observation_layout
        samples = self._bank.samples(self._places[: layout.preview + 1].T)
        if not self.settings.features:
            return layout.encode(*self._seen, self.action, samples)
        # errors that the base asks for itself say nothing of the machine
        n, at = self.robot.n_joints, self.columns
        asked, base = self._rows[:, at.base_error], self._next_base(slice(None))
        error, error_rate = self._seen[0] - asked[:, :n], self._seen[1] - asked[:, n:]
        return layout.encode(error, error_rate, self.action, samples, base)

    def _reward(self, stopped: BoolArray) -> Array:
        """Compute the reward of the last step, shape (B,)."""
        if self._one_reward:
            return self._rewards[0](self.signals, self.robot, stopped)
        rewards = {id(reward): reward for reward in self._rewards}
        each = {key: reward(self.signals, self.robot, stopped) for key, reward in rewards.items()}
        return np.array([each[id(reward)][i] for i, reward in enumerate(self._rewards)])

    def info(self) -> dict[str, Any]:
        """Return signals of machine and simulation beside the observation, each of shape (B, ...), copies."""
        now, signals, at = self._rows, self.signals, self.columns
        out: dict[str, Any] = {
            "time": self.time,
            "u_c": signals.feedback.u_fb.copy(),
            "u_i": signals.feedback.u_i.copy(),
            "u_p": signals.feedback.u_p,  # computed when it is asked for
            "phase": _PHASES.take(now[:, at.phase].astype(np.int64)),
            "circle": now[:, at.circle].astype(np.int64),
            "task": self._labels.copy(),
            "clipped": self.clipped.copy(),
            "practice": self._practice.copy(),
        }
        if signals.tcp is not None and signals.path_error is not None:
            out |= {"tcp": signals.tcp.copy(), "path_error": signals.path_error.copy()}
        return out


def _tile_gains(servo: Servo, n: int) -> Servo:
    """Return the gains of a servo for each of `n` robots, (B, N)."""
    return Servo(
        position_gain=np.tile(servo.position_gain, (n, 1)),
        velocity_gain=np.tile(servo.velocity_gain, (n, 1)),
        integral_gain=np.tile(servo.integral_gain, (n, 1)),
        control_dt=servo.control_dt,
    )
