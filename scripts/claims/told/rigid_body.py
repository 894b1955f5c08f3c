"""What docs/rigid_body_identification.md tells of the code."""

from collections.abc import Iterator

from ffgym.diagnosis.identification.rigid_body.identify import EXCITED, RigidBodyOptions
from ffgym.diagnosis.identification.rigid_body.problem import SPREADS
from scripts.claims.claim import claim
from scripts.tables.recorded import AUTHORS_FILTERING, NEAR_CAD

CODE = "the code itself"


@claim(CODE)
def rigid_body_filters() -> Iterator[str]:
    """Filters and rows of the equations."""
    filters = RigidBodyOptions().filtering
    yield f"low-passed forward and backward ({filters.motion.cutoff:g} Hz)"
    yield f"low-pass together ({filters.parallel.cutoff:g} Hz)"
    yield f"slower than {filters.moving:g} rad/s (at the joint)"
    yield f"Rigid bodies below {filters.parallel.cutoff:g} Hz."
    yield f"{filters.parallel.cutoff:g} Hz leave little of the inertia"


@claim(CODE)
def rigid_body_priors() -> Iterator[str]:
    """Spreads, and shares of the data that are enough."""
    yield f"Eight values from {min(SPREADS):g} to {max(SPREADS):g} are tried"
    assert len(SPREADS) == 8
    yield f"whose share is below {EXCITED:g} is dropped"
    yield f"Intervals ({100 * RigidBodyOptions().level:g} %) come from blocks"


@claim("scripts/tables/recorded.py")
def settings_of_recorded_machines() -> Iterator[str]:
    """Filters of the authors, and the spread of masses that are believed."""
    motion, both = AUTHORS_FILTERING.motion.cutoff, AUTHORS_FILTERING.parallel.cutoff
    yield f"position at {motion:g} Hz, both sides at {both:g} Hz, every tenth row"
    cutoff = RigidBodyOptions().filtering.parallel.cutoff
    yield f"whose spread of {NEAR_CAD:g} had been declared"
    yield f"filtered at {cutoff:g} Hz; in brackets the spread s. *near CAD* believes the masses (s = {NEAR_CAD:g})"
    yield f"where ripple above {cutoff:g} Hz counts"
