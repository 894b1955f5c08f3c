"""A diagnosis with the residuals that it was made from, and the places in them that are worth a look."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.held_out import LoopLevel
from ffgym.diagnosis.regimes import map_by_motion
from ffgym.diagnosis.residual import Channel, Residual
from ffgym.diagnosis.result import Diagnosis
from ffgym.report.diagnosis.words import by_model, in_joint_units

STANDS_OUT = 1.5
"""Residual over noise floor of a whole log from which a component is shown; chosen: half as much again as noise."""

MOST_PLACES = 3
"""Components that are shown in detail."""


@dataclass(frozen=True, kw_only=True)
class Place:
    """One joint in one channel."""

    channel: Channel
    component: str
    index: int
    """Index of the component, which is also that of the joint."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DiagnosisReport:
    """Everything that is shown; residuals before and after are of the same motions."""

    diagnosis: Diagnosis
    before: Residual | None = None
    """Against the nominal model; None if the logs do not allow a diagnosis."""
    after: Residual | None = None
    """Against the extended model; None without causes."""
    held_out: Sequence[LoopLevel] = ()
    """Both models replayed along recordings that were not diagnosed, if there are."""
    closed_loop: Sequence[LoopLevel] = ()
    """Whole closed loops of both models beside the machine's, on recordings that were not diagnosed, if there are."""
    commands: Sequence[str] = ()
    """Commands to go on with, which run as they are printed."""

    def __post_init__(self) -> None:
        if self.after is not None and (self.before is None or _motions(self.before) != _motions(self.after)):
            raise FFGymError("Residuals before and after must be of the same motions in the same order.")

    @property
    def models(self) -> dict[str, Residual]:
        """Residuals by the name of the model: none, the nominal one, or also the extended one."""
        return by_model(self.before, self.after)

    @property
    def in_joint_units(self) -> Diagnosis:
        """The diagnosis with sizes and levels of sliding joints behind the gearbox."""
        return in_joint_units(self.diagnosis, None if self.before is None else self.before.robot)

    @property
    def places(self) -> tuple[Place, ...]:
        """Joints to look at: those of causes first, then those that stand out most; at least the worst one."""
        if self.before is None:
            return ()
        found = []
        for channel in self.before.channels:
            if channel != "tool":
                over = map_by_motion(self.before, channel).overall
                for index, (component, ratio) in enumerate(zip(self.before.robot.joints, over, strict=True)):
                    if np.isfinite(ratio):
                        found.append((Place(channel=channel, component=component, index=index), float(ratio)))
        ranked = sorted(found, key=lambda entry: -entry[1])
        blamed = {cause.joint for cause in self.diagnosis.causes}
        standing_out = [place for place, ratio in ranked if ratio > STANDS_OUT] or [place for place, _ in ranked[:1]]
        first = [place for place in standing_out if place.component in blamed]
        return tuple(dict.fromkeys([*first, *standing_out]))[:MOST_PLACES]


def _motions(residual: Residual) -> tuple[str, ...]:
    return tuple(motion.motion for motion in residual.motions)
