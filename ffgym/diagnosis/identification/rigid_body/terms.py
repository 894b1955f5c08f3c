"""The terms that there are, and how they are named."""

from collections.abc import Sequence

from ffgym.core.errors import FFGymError, check_choice
from ffgym.diagnosis.identification.rigid_body.arm_terms import Bodies, Springs
from ffgym.diagnosis.identification.rigid_body.motor_terms import (
    Coulomb,
    Offset,
    RotorInertia,
    Viscous,
    ViscousAsymmetry,
)
from ffgym.diagnosis.identification.rigid_body.term import Term

TERMS: tuple[Term, ...] = (
    Bodies(), Springs(), RotorInertia(), Coulomb(), Viscous(), Offset(), ViscousAsymmetry()
)  # fmt: skip
"""All terms there are, in the order in which their parameters stand."""

DEFAULT_TERMS = ("bodies", "rotor_inertia", "coulomb", "viscous", "offset")
"""What is fitted unless asked otherwise; springs stay as described, and friction is the same in both directions."""


def terms_named(names: Sequence[str]) -> tuple[Term, ...]:
    """Terms by name, in the order of TERMS.

    Raises:
        FFGymError: if there are none, or a name is unknown.
    """
    for name in names:
        check_choice("term", name, [term.name for term in TERMS])
    if not names:
        raise FFGymError(f"There is nothing to fit: no terms. Available: {', '.join(term.name for term in TERMS)}.")
    return tuple(term for term in TERMS if term.name in names)
