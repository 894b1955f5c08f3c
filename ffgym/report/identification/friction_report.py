"""A friction identification with everything that is shown of it."""

from collections.abc import Sequence
from dataclasses import dataclass

from ffgym.diagnosis.identification import FrictionIdentification, FrictionTorque, Validation


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionReport:
    """What was found, from what, and how well it holds elsewhere."""

    identification: FrictionIdentification
    used: Sequence[FrictionTorque]
    """Friction along the recordings that were used."""
    held_out: Sequence[FrictionTorque]
    """Friction along those that were not."""
    before: Sequence[Validation]
    """Errors of the old parameters on records that were not used."""
    after: Sequence[Validation]
    """Errors of the new ones on the same."""
    doubts: Sequence[str] = ()
    """What speaks against logs that were used all the same."""
