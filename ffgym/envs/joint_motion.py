"""`ffgym/JointMotion-v0`: random smooth motions of all joints, no path, for training that should carry over to any."""

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.envs.motion import EpisodeMotion
from ffgym.envs.single import TrackingEnv
from ffgym.envs.tasks import Tasks
from ffgym.envs.vector import TrackingVectorEnv
from ffgym.paths import joint_reference, random_multisine
from ffgym.robot import RobotDescription

PEAK_SPEEDS = (0.2, 20.0)
"""Range of the fastest motor speed of each joint [rad/s]: from presliding to the fastest motor of the circle test."""


class RandomTasks(Tasks):
    """Random multisines; each episode has its own, and each joint its own peak speed.

    Args:
        robot: nominal one of the controller: description, built-in name, or path to a description ending in .toml.
        duration: length of an episode [s].
        peak_speeds: range of the largest speed of each joint, motor side [rad/s], without the share of couplings; drawn
            log-uniformly.
        spread: the centre of the motion is drawn within +- this of the home pose, link side [rad or m].
    """

    option_names = ("centre", "peak_speed")

    def __init__(
        self,
        robot: RobotDescription | str | Path = "irb4600_60_205",
        *,
        duration: float = 2.0,
        peak_speeds: tuple[float, float] = PEAK_SPEEDS,
        spread: float = 0.3,
    ) -> None:
        super().__init__(robot)
        self._duration = check_number("duration", duration, unit="s", low=0.0, open_low=True)
        low, high = check_shape("peak_speeds", peak_speeds, (2,)).tolist()
        if not 0 < low <= high:
            raise FFGymError(f"peak_speeds = ({low}, {high}) rad/s must be 0 < low <= high.")
        self._peak_speeds = (low, high)
        self._spread = check_number("spread", spread, unit="rad", low=0.0)
        self.draw(np.random.default_rng(0), {})  # refuse now, not in the middle of a training

    def draw(self, rng: np.random.Generator, options: Mapping[str, Any]) -> EpisodeMotion:
        """Draw a multisine: centre, peak speeds, then sines."""
        n, kinematics = self.robot.n_joints, self.robot.kinematics
        # random centre near home, and peak speeds drawn log-uniformly
        home = np.zeros(n) if self.robot.work_area is None else self.robot.work_area.home
        centre = home + rng.uniform(-self._spread, self._spread, size=n)
        speed = np.exp(rng.uniform(np.log(self._peak_speeds[0]), np.log(self._peak_speeds[1]), size=n))
        middle, half = kinematics.range.mean(axis=1), np.diff(kinematics.range, axis=1)[:, 0] / 2
        low, high = middle - 0.8 * half, middle + 0.8 * half  # leaves room for the motion about its centre
        centre = np.clip(centre, low, high)
        # centre and peak speeds that options fix
        if "centre" in options:
            centre = check_shape("centre", options["centre"], (n,))
            if np.any((centre < low) | (centre > high)):
                raise FFGymError(
                    f"centre = {centre} must be within the middle 80 % of the joint ranges, {low} to {high} [rad or m]."
                )
        if "peak_speed" in options:
            speed = options["peak_speed"]
            with suppress(ValueError):  # then check_shape names the mistake
                speed = np.broadcast_to(speed, n)
            speed = check_shape("peak_speed", speed, (n,))
            if np.any(speed < 0):
                raise FFGymError(f"peak_speed = {speed} rad/s must be >= 0 on every joint.")
        # multisine on all joints
        joint_speed = speed / np.abs(self.robot.drive.gear_ratio)
        path = random_multisine(rng, centre, joint_speed, self._duration, dt=self.robot.servo.control_dt)
        task = {"centre": centre.tolist(), "peak_speed": speed.tolist()}
        return EpisodeMotion(reference=joint_reference(self.robot, path), arm=self.arm, task=task)


class JointMotionVectorEnv(TrackingVectorEnv):
    """Robots on random smooth joint motions, a new one for each episode.

    Keyword arguments are those of `RandomTasks` and of `ffgym.envs.EnvSettings`.
    """

    tasks = RandomTasks


class JointMotionEnv(TrackingEnv):
    """One robot on random smooth joint motions; keyword arguments as `JointMotionVectorEnv`."""

    kind = JointMotionVectorEnv
