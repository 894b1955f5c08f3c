"""The learning curve of a training, and how far it is."""

from collections.abc import Callable

from stable_baselines3.common.callbacks import BaseCallback

from ffgym.agents.residual.plan import Training

Points = tuple[tuple[int, float], ...]
"""Steps, mean reward per step since the point before."""
POINTS = 4
"""Points of the curve in a segment, if it has as many steps."""


class Curve(BaseCallback):
    """Mean reward per step, with exploration, in even parts of every segment.

    Args:
        training: what is trained.
        points: of the curve so far.
        watch: is told steps that are done, and all; None is nobody.
    """

    def __init__(
        self,
        training: Training,
        points: Points,
        watch: Callable[[int, int], object] | None,
    ) -> None:
        super().__init__()
        self.points = points
        self._every = -(-training.integer("segment_steps") // POINTS)
        self._total, self._watch = training.total, watch
        self._sum, self._count = 0.0, 0

    def _on_training_start(self) -> None:
        self._sum, self._count = 0.0, 0

    def _on_step(self) -> bool:
        rewards = self.locals["rewards"]
        self._sum += float(rewards.sum())
        self._count += len(rewards)
        if self._count >= self._every:
            self._close()
        if self._watch is not None:
            self._watch(min(self.num_timesteps, self._total), self._total)
        return True

    def _on_training_end(self) -> None:
        if self._count:
            self._close()

    def _close(self) -> None:
        mean = self._sum / self._count
        self.points = (*self.points, (self.num_timesteps, mean))
        self.logger.record("train/reward_per_step", mean)
        self.logger.dump(self.num_timesteps)  # now: SAC and TQC else write when episodes end, the last point alone
        self._sum, self._count = 0.0, 0
