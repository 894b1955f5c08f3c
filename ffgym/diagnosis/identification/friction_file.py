"""Identified friction as entries of a parameter file."""

from collections.abc import Mapping, Sequence

import numpy as np

from ffgym.diagnosis.identification.estimate import Estimate
from ffgym.diagnosis.identification.friction import FrictionIdentification
from ffgym.diagnosis.identification.parameter_file import fitted_quantity
from ffgym.robot.reading.quantity import Quantity

_NAMED = 6
"""Logs that a source names."""


def friction_quantities(identification: FrictionIdentification) -> Mapping[str, Quantity]:
    """Entries [friction.*] for a parameter file: numbers, intervals, what they rest on, and what was before.

    Joints for which the data do not tell an entry keep its number and its origin; an entry that no joint tells is left
    out, and stays what the description says.
    """
    entries = {}
    for i, estimate in enumerate(identification.joints[0].estimates):
        column = [joint.estimates[i] for joint in identification.joints]
        if any(_is_new(own) for own in column):
            entries[estimate.name] = _quantity(identification, column)
    return entries


def _is_new(estimate: Estimate) -> bool:
    """Whether a number replaces that of the description: found, given by the caller, or moved to fit what was found."""
    return estimate.is_identified or estimate.value != estimate.prior


def _quantity(identification: FrictionIdentification, column: list[Estimate]) -> Quantity:
    """One entry for all joints."""
    robot, path = identification.prior, column[0].name
    before = robot.quantities[path].origin if path in robot.quantities else ("chosen",)
    kept = before * len(column) if len(before) == 1 else before
    origin = tuple("fitted" if _is_new(own) else old for own, old in zip(column, kept, strict=True))
    others = [f"{own.joint}: {own.status}, {own.reason}" for own in column if not own.is_identified]
    source = f"ffgym identify from {_named(identification.segments)}; {identification.level:.0%} intervals"
    return fitted_quantity(
        robot,
        path,
        np.array([own.value for own in column]),
        "; ".join([source, *others]),
        origin,
        np.array([[own.low, own.high] for own in column]),
    )


def _named(segments: Sequence[str]) -> str:
    """Logs in a few words."""
    more = f" and {len(segments) - _NAMED} more logs" if len(segments) > _NAMED else ""
    return ", ".join(segments[:_NAMED]) + more
