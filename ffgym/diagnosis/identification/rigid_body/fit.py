"""Result of a rigid-body identification: parameters with intervals, their origin, and the torque that they predict."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.identification.parameter_file import entry_of, make_fitted_quantity
from ffgym.diagnosis.identification.rigid_body.base import BaseParameters
from ffgym.diagnosis.identification.rigid_body.observation import (
    Equations,
    Filtering,
    TorqueErrors,
    equations_of,
    torque_errors,
)
from ffgym.diagnosis.identification.rigid_body.problem import TradeOff
from ffgym.diagnosis.identification.rigid_body.terms import BODIES, Term
from ffgym.diagnosis.resampling import Intervals, intervals
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription
from ffgym.robot.reading.quantity import Quantity

UNEXPLAINED = 0.2
"""Share of a motor's RMS torque that a fit may leave; chosen: of the run that is fitted it leaves at most 4 % on the
recorded machines of docs/rigid_body_identification.md, and 32 % to 103 % where the torque has the wrong sign."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RigidBodyFit:
    """Parameters of a rigid arm, K of them, from recordings."""

    robot: RobotDescription
    """The description that the fit is near."""
    terms: tuple[Term, ...]
    filtering: Filtering
    segments: tuple[str, ...]
    """Names of the recordings."""
    described: Array
    """Shape (K,)."""
    estimate: Array
    """Shape (K,)."""
    in_file: Array
    """The best parameters without the terms that no description holds, which stay as described, shape (K,)."""
    resampled: Array
    """Estimates from resampled recordings and descriptions drawn within the spread, shape (B, K)."""
    level: float
    """Probability of intervals."""
    shares: Array
    """How much of each parameter the data say, from 0, all the description, to 1, all the data, shape (K,)."""
    fitted: BoolArray
    """False for friction terms and offsets that the motion does not tell from others: they stay as described, (K,)."""
    trade_off: TradeOff
    """How far masses and rotors may be from the description, and why."""
    base: BaseParameters
    """Combinations that torque can tell at all."""
    base_shares: Array
    """How much of each combination the data say, shape (B,)."""
    condition: float
    """Condition number of the weighted equations for base parameters, columns at unit size."""
    errors: TorqueErrors
    """On the recordings that were fitted."""

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return self.base.labels

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the parameters, motor side for rotors and friction."""
        return tuple(unit for term in self.terms for unit in term.units(self.robot))

    @property
    def not_excited(self) -> tuple[str, ...]:
        """Names of the parameters that were dropped."""
        return tuple(label for label, fitted in zip(self.labels, self.fitted, strict=True) if not fitted)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Sentences about motors whose torque is left unexplained, and a description that is too far off."""
        errors, trade_off = self.errors, self.trade_off
        doubts = [
            f"{self.robot.joints[j]}: {errors.identified[j] / errors.measured[j]:.0%} of its torque is left "
            "unexplained. Look for a wrong sign, unit, side of the gearbox or gear ratio, or for a torque that is no "
            "rigid body's."
            for j in np.flatnonzero(errors.identified > UNEXPLAINED * errors.measured)
        ]
        if len(trade_off.spreads) > 1 and trade_off.chosen == trade_off.spreads.max():
            doubts.append(
                f"Held-out parts are predicted best with the largest spread that was tried, {trade_off.chosen:g}: "
                "masses or rotors of the description, or the unit of the torque, are off by a factor. Begin with "
                "better ones."
            )
        return tuple(doubts)

    @property
    def intervals(self) -> Intervals:
        """Intervals of the parameters."""
        return intervals(self.estimate, self.resampled, self.level)

    @property
    def base_intervals(self) -> Intervals:
        """Intervals of the base parameters."""
        return intervals(self.base.values(self.estimate), self.base.values(self.resampled), self.level)

    def of(self, label: str) -> float:
        """One parameter by name."""
        return float(self.estimate[self.labels.index(label)])

    @property
    def identified(self) -> RobotDescription:
        """The robot with `in_file` in place of its own numbers."""
        robot = self.robot
        for term, values in self._by_term(self.in_file):
            robot = term.applied(robot, values)
        return robot

    @property
    def quantities(self) -> dict[str, Quantity]:
        """List the entries of a parameter file with these numbers."""
        found, segments = self.identified, ", ".join(map(repr, self.segments))
        source = (
            f"rigid-body fit to {segments}; masses and rotors held near the prior, relative standard deviation "
            f"{self.trade_off.chosen:g}"
        )
        paths = [path for term in self.terms for path in term.entries(self.robot)]
        return {path: make_fitted_quantity(self.robot, path, entry_of(found, path), source) for path in paths}

    def validate(self, recordings: Sequence[Recording]) -> TorqueErrors:
        """Errors on recordings that were not fitted."""
        return torque_errors(self.equations(recordings), self.estimate, self.in_file)

    def equations(self, recordings: Sequence[Recording]) -> Equations:
        """Equations of recordings, filtered as those that were fitted; joints bend under the bodies that were found."""
        bodies = next((values for term, values in self._by_term(self.estimate) if term is BODIES), None)
        return equations_of(self.robot, recordings, self.terms, self.filtering, bodies)

    def _by_term(self, parameters: Array) -> list[tuple[Term, Array]]:
        """Terms with those of `parameters` (K,) that are theirs."""
        counts = [len(term.labels(self.robot)) for term in self.terms]
        return list(zip(self.terms, np.split(parameters, np.cumsum(counts)[:-1]), strict=True))
