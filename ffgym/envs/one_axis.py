"""`ffgym/OneAxis-v0`: the one-axis test of the thesis (2.2.2, 4.3.1): a sine on one motor."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.core.errors import check_number, check_shape
from ffgym.envs.motion import EpisodeMotion
from ffgym.envs.single import TrackingEnv
from ffgym.envs.tasks import Tasks, check_not_empty
from ffgym.envs.vector import TrackingVectorEnv
from ffgym.robot import RobotDescription
from ffgym.studies.one_axis import sine_reference


class SineTasks(Tasks):
    """Sines of one joint.

    Args:
        robot: nominal one of the controller: description, built-in name, or path to a description ending in .toml,
            with one joint.
        frequencies: frequencies [Hz], one is drawn for each episode; the thesis has 1 and 3.
        amplitude: amplitude of the motor [rad].
        duration: length of an episode [s].
    """

    option_names = ("frequency", "amplitude")

    def __init__(
        self,
        robot: RobotDescription | str | Path = "one_axis",
        *,
        frequencies: Sequence[float] = (1.0, 3.0),
        amplitude: float = 1.0,
        duration: float = 10.0,
    ) -> None:
        super().__init__(robot)
        values = tuple(check_shape("frequencies", np.atleast_1d(frequencies), (None,)).tolist())
        self._frequencies = check_not_empty("frequencies", values, "1.0 Hz")
        self._amplitude = check_number("amplitude", amplitude, unit="rad")
        self._duration = check_number("duration", duration, unit="s", low=0.0, open_low=True)
        for task in self.list_options():
            self.draw(np.random.default_rng(0), task)  # refuse now, not in the middle of a training

    def draw(self, rng: np.random.Generator, options: Mapping[str, Any]) -> EpisodeMotion:
        """Draw the frequency of a sine."""
        chosen = (
            options["frequency"] if "frequency" in options else self._frequencies[rng.integers(len(self._frequencies))]
        )
        frequency = check_number("frequency", chosen, unit="Hz", low=0.0, open_low=True)
        amplitude = check_number("amplitude", options.get("amplitude", self._amplitude), unit="rad")

        def make() -> EpisodeMotion:
            reference = sine_reference(self.robot, frequency, amplitude, self._duration)
            return EpisodeMotion(
                reference=reference, arm=self.arm, task={"frequency": frequency, "amplitude": amplitude}
            )

        return self._keep_motion((frequency, amplitude), make)

    def list_options(self) -> list[dict[str, Any]]:
        """List every frequency."""
        return [{"frequency": frequency} for frequency in self._frequencies]


class OneAxisVectorEnv(TrackingVectorEnv):
    """One-axis robots that follow a sine.

    Keyword arguments are those of `SineTasks` and of `ffgym.envs.EnvSettings`.
    """

    tasks = SineTasks


class OneAxisEnv(TrackingEnv):
    """A one-axis robot that follows a sine; keyword arguments as `OneAxisVectorEnv`."""

    kind = OneAxisVectorEnv
