"""`ffgym play`: one episode of an environment as a video."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ffgym.cli._movie import check_movie, movie
from ffgym.cli.outputs import check_outputs, provenance
from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.core.files import write_json
from ffgym.core.registration import ENVIRONMENTS
from ffgym.core.types import Array
from ffgym.robot import RobotDescription

ACTION_SCALE = 8.0
"""Torque of an action of 1, in breakaway torques: enough for every law, so that none is clipped."""
CIRCLES = ("ffgym/CirclePath-v0", "ffgym/WorkcellCircles-v0")
"""Environments of the circle test; the second is that of workcells."""
USUAL = {"ffgym/OneAxis-v0": "one_axis", CIRCLES[1]: "workcell:thesis"}
"""Robots of environments that are not for the built-in arm."""
LAWS = {"none": "no compensation", "lugre_static": "static LuGre", "lugre_dynamic": "dynamic LuGre"}
"""Feed-forward laws, and what the picture calls them."""


@dataclass(frozen=True)
class Play:
    """Film one episode under a feed-forward law; the error is drawn magnified, the picture says how much."""

    out: Path = Path("episode.mp4")
    """Video to write, .mp4 or .gif."""
    env: str = "ffgym/CirclePath-v0"
    """Id of the environment."""
    robot: str | None = None
    """Built-in robot, a path that ends in .toml to a description or a machine file, or workcell:<name or seed>; none
    given is the environment's own."""
    law: Literal["none", "lugre_static", "lugre_dynamic"] = "none"
    """Feed-forward law, with the friction parameters that the robot's controller knows."""
    path: str | None = None
    """Motion to follow, a name or a file as for `ffgym simulate` (ffgym/FollowPath-v0 only); none given is circles."""
    position: str | None = None
    """Position in the work area (circles only); none given is p1."""
    speed_mm_s: float | None = None
    """TCP speed (circles only); none given is 40 mm/s."""
    radii_mm: tuple[float, ...] = ()
    """Circle radii (circles only); none given is all of the test."""
    frequency_hz: float | None = None
    """Frequency of the sine (one axis only); none given is 1 Hz."""
    magnify: float | None = None
    """Factor on the drawn error; none given is one that suits the motion."""
    playback: float = 0.5
    """Speed of the video: 1 is real time, 0.1 ten times slower."""
    fps: float = 25.0
    """Pictures per second of the video."""
    width: int = 960
    """Of the picture [pixel]."""
    height: int = 540
    """Of the picture [pixel]."""
    seed: int = 0
    """Of everything that the environment draws."""
    json: Path | None = None
    """Also write return, length, errors and origin to this file."""

    def run(self) -> None:
        """Check, simulate and draw, write."""
        self._check()
        from ffgym.cli.progress import progress_bar

        env = self._make()
        try:
            with progress_bar("filming", "steps") as progress, movie(self.out, self.fps) as append:
                result = self._film(env, append, progress)
            if self.json is not None:
                write_json(self.json, self._provenance(env) | result)
        finally:
            env.close()
        error = result["rms_path_error_mm"]
        print(f"{result['frames']} frames, return {result['return']:.2f}, length {result['length']}", end="")
        print("" if error is None else f", path error {error:.4f} mm RMS")
        print(f"video: {self.out}")
        if self.json is not None:
            print(f"numbers: {self.json}")

    def _check(self) -> None:
        check_choice("environment", self.env, list(ENVIRONMENTS))
        for kinds, names in {
            CIRCLES: ("position", "speed_mm_s", "radii_mm"),
            ("ffgym/OneAxis-v0",): ("frequency_hz",),
            ("ffgym/FollowPath-v0",): ("path",),
        }.items():
            given = [f"--{name.replace('_', '-')}" for name in names if getattr(self, name) not in (None, ())]
            if given and self.env not in kinds:
                raise FFGymError(
                    f"{' and '.join(given)} is for {' or '.join(kinds)}, not for {self.env}; leave it out."
                )
        check_number("playback", self.playback, low=0.0, high=1000.0, open_low=True)
        check_number("fps", self.fps, unit="1/s", low=1.0, high=100.0)
        check_whole("seed", self.seed, low=0)
        check_movie(self.out)
        check_outputs({"--out": self.out, "--json": self.json})

    def _make(self) -> Any:
        """The environment."""
        import gymnasium as gym

        from ffgym.envs import Residual
        from ffgym.envs.rendering import Rendering
        from ffgym.studies import thesis_laws

        robot, machine = self._machine(USUAL.get(self.env, "irb4600_60_205") if self.robot is None else self.robot)
        law = next(law for law in thesis_laws(robot) if law.name == self.law)
        return gym.make(
            self.env,
            render_mode="rgb_array",
            layers=(Residual(law),),
            action_scale=ACTION_SCALE,
            rendering=Rendering(magnify=self.magnify, width=self.width, height=self.height, title=LAWS[self.law]),
            **machine,
            **self._motion(),
        ).unwrapped

    def _machine(self, name: str) -> tuple[RobotDescription, dict[str, Any]]:
        """What the machine's controller knows of it, and the environment's arguments that say which machine it is."""
        from ffgym.envs.machines import WORKCELL, is_workcell, rig_of
        from ffgym.simulation.plant.machine_file import is_machine_file

        robot = rig_of(name).robot
        if self.env == CIRCLES[1]:
            if not is_workcell(name):
                raise FFGymError(f"--robot {name} is no workcell; give workcell:<name or seed>, or --env {CIRCLES[0]}.")
            return robot, {"workcell": name.removeprefix(WORKCELL)}
        return robot, {"robot": robot} | ({"plant": name} if is_workcell(name) or is_machine_file(name) else {})

    def _motion(self) -> dict[str, Any]:
        if self.env == "ffgym/OneAxis-v0":
            return {"frequencies": [1.0 if self.frequency_hz is None else self.frequency_hz]}
        if self.env == "ffgym/FollowPath-v0":
            return {} if self.path is None else {"path": self.path}
        if self.env not in CIRCLES:
            return {}
        speed = 40.0 if self.speed_mm_s is None else self.speed_mm_s
        radii = {"radii": [radius / 1e3 for radius in self.radii_mm]} if self.radii_mm else {}
        return {"positions": [self.position or "p1"], "speeds": [speed / 1e3], **radii}

    def _film(
        self, env: Any, append: Callable[[NDArray[np.uint8]], None], progress: Callable[[float, float], None]
    ) -> dict[str, Any]:
        """Run an episode; frame k shows the first control step at or after time k playback / fps."""
        _, info = env.reset(seed=self.seed)
        action, total = np.zeros(env.action_space.shape), env.core.motions[0].n_steps
        between = self.playback / self.fps / env.decision_dt  # control steps
        rewards: list[float] = []
        path: list[float] = []
        motor: list[Array] = []
        frames, ended = 0, False
        while True:
            while frames * between <= len(rewards) + 1e-9:
                append(env.render())
                frames += 1
            if ended:
                break
            _, reward, terminated, truncated, info = env.step(action)
            ended = terminated or truncated
            rewards.append(reward)
            motor.append(env.core.signals.error[0])
            if "path_error" in info and info["phase"] in ("circle", "motion"):
                path.append(info["path_error"])
            progress(len(rewards), total)
        return {
            "frames": frames,
            "return": float(np.sum(rewards)),
            "length": len(rewards),
            "terminated": bool(terminated),
            "rms_path_error_mm": 1e3 * float(np.sqrt(np.mean(np.square(path)))) if path else None,
            "rms_motor_error_rad": np.sqrt(np.mean(np.square(motor), axis=0)).tolist(),
        }

    def _provenance(self, env: Any) -> dict[str, Any]:
        """Origin of the numbers."""
        info = provenance(
            "ffgym play", self, self.robot or env.core.robot.name, env.core.plant.fingerprint(), seed=self.seed
        )
        return info | {"task": env.core.motions[0].task}
