"""A rigid-body identification with everything that is shown of it, and its rows and numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.identification.rigid_body import RigidBodyFit, TorqueErrors
from ffgym.recordings import Recording

SURE = 0.9
"""Share of the data from which a number is theirs."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RigidBodyReport:
    """What was found, and how well it holds elsewhere."""

    fit: RigidBodyFit
    held_out: Sequence[Recording]
    """Recordings that were not used."""
    doubts_of_logs: Sequence[str] = ()
    """What speaks against logs that were used all the same."""

    @property
    def doubts(self) -> tuple[str, ...]:
        """What speaks against logs and fit."""
        return (*self.doubts_of_logs, *self.fit.doubts)

    @property
    def validation(self) -> Mapping[str, TorqueErrors]:
        """Errors on the recordings that were used, and on each that was not."""
        errors = {"logs": self.fit.errors}
        return errors | {record.header.segment: self.fit.validate([record]) for record in self.held_out}


@dataclass(frozen=True, kw_only=True)
class Row:
    """A parameter, or a combination of parameters."""

    name: str
    unit: str
    before: float
    now: float
    low: float
    high: float
    share: float
    """Of the data."""
    verdict: str


def parameter_rows(fit: RigidBodyFit) -> list[Row]:
    """Rotors, friction, offsets, springs: all but the bodies."""
    low, high = fit.intervals.low, fit.intervals.high
    return [
        Row(
            name=label,
            unit=fit.units[i],
            before=float(fit.described[i]),
            now=float(fit.estimate[i]),
            low=float(low[i]),
            high=float(high[i]),
            share=float(fit.shares[i]),
            verdict=_verdict(bool(fit.fitted[i]), float(fit.shares[i])),
        )
        for i, label in enumerate(fit.labels)
        if label.split(".")[0] not in (*fit.robot.links, "tool")
    ]


def base_rows(fit: RigidBodyFit) -> list[Row]:
    """Combinations that torque can tell."""
    before, now = fit.base.values(fit.described), fit.base.values(fit.estimate)
    low, high = fit.base_intervals.low, fit.base_intervals.high
    return [
        Row(
            name=fit.base.text(i),
            unit=fit.units[own],
            before=float(before[i]),
            now=float(now[i]),
            low=float(low[i]),
            high=float(high[i]),
            share=float(fit.base_shares[i]),
            verdict=_verdict(bool(fit.fitted[own]), float(fit.base_shares[i])),
        )
        for i, own in enumerate(fit.base.own)
    ]


def body_rows(fit: RigidBodyFit) -> list[tuple[str, float, float, float]]:
    """Name, mass before and now [kg], and how many of its ten numbers the data say, of each body."""
    names = [label.removesuffix(".mass") for label in fit.labels if label.endswith(".mass")]
    start = {name: fit.labels.index(f"{name}.mass") for name in names}
    return [
        (name, float(fit.described[i]), float(fit.estimate[i]), float(fit.shares[i : i + 10].sum()))
        for name, i in start.items()
    ]


def rigid_body_numbers(report: RigidBodyReport) -> dict[str, Any]:
    """Everything, as JSON has it."""
    fit = report.fit
    return {
        "logs": list(fit.segments),
        "level": fit.level,
        "spread": {
            "chosen": fit.trade_off.chosen,
            "tried": fit.trade_off.spreads.tolist(),
            "held_out_errors": _plain(fit.trade_off.errors),
        },
        "condition": fit.condition if np.isfinite(fit.condition) else None,
        "not_excited": list(fit.not_excited),
        "parameters": [
            {"name": label, "unit": unit, "described": x0, "value": x, "low": low, "high": high, "data_share": share}
            for label, unit, x0, x, low, high, share in zip(
                fit.labels, fit.units, *map(_plain, _columns(fit)), strict=True
            )
        ],
        "base_parameters": [vars(row) for row in base_rows(fit)],
        "errors_nm": {
            name: {kind: _plain(values) for kind, values in vars(errors).items()}
            for name, errors in report.validation.items()
        },
        "doubts": list(report.doubts),
    }


def _columns(fit: RigidBodyFit) -> tuple[Array, ...]:
    return fit.described, fit.estimate, fit.intervals.low, fit.intervals.high, fit.shares


def _plain(values: Array) -> list[float | None]:
    """JSON has no NaN."""
    return [float(value) if np.isfinite(value) else None for value in values]


def _verdict(fitted: bool, share: float) -> str:
    if not fitted:
        return "not excited"
    return "data" if share >= SURE else "description" if share < 1 - SURE else "both"
