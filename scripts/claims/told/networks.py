"""What docs/agents/bspline.md tells of the stored record of the demo, and of the code."""

from collections.abc import Iterator

import numpy as np

from ffgym.agents import SplineBasis
from scripts.claims.claim import claim
from scripts.claims.records import numbers_of
from scripts.tables.networks import motor_mrad, path_mm

AGAIN = "python -m scripts.claims --record networks"


@claim(AGAIN)
def networks_on_circles() -> Iterator[str]:
    """What networks gain where they were not trained, and on one axis."""
    none, ideal = (motor_mrad(agent, 40.0) for agent in ("none", "lugre_dynamic"))
    zero, both = (
        100 * (none - motor_mrad(name, 40.0)) / (none - ideal) for name in ("bsn_extended", "bsn_extended_prior")
    )
    yield (
        f"from zero weights {zero:.0f} % of what ideal friction compensation gains at the motors, and nothing at the "
        f"tool ({path_mm('none', 40.0):.3f} mm without, {path_mm('bsn_extended', 40.0):.3f} mm with the extended "
        "network, all positions)"
    )
    yield f"together {both:.0f} %, and {path_mm('bsn_extended_prior', 40.0):.3f} mm."
    yield f"over all positions against {path_mm('bsn_extended_prior', 100.0):.3f} mm, because"
    left = {(row["agent"], row["frequency_hz"]): 100 * row["reduction"] for row in numbers_of("networks")["one_axis"]}
    told = [f"{left[name, 1.0]:.1f} and {left[name, 3.0]:.1f} %" for name in ("bsn_static", "bsn_extended")]
    prior = f"{left['bsn_extended_prior', 1.0]:.1f} and {left['bsn_extended_prior', 3.0]:.1f} %"
    yield f"static {told[0]}, extended {told[1]}, extended with prior {prior}."


@claim("ffgym.agents.SplineBasis")
def knots() -> Iterator[str]:
    """Knots of the splines of the thesis."""
    basis = SplineBasis()
    inner = np.abs(basis.knots) <= 1.0
    yield (
        f"have {basis.knots.size} knots, {inner.sum()} of them in +-1 rad/s, {(~inner).sum()} outside up to "
        f"+-{np.abs(basis.knots).max():g} rad/s, and order {basis.order} (hats)."
    )
