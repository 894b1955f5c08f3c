"""What docs/agents/bspline.md tells of the stored record of the demo, and of the code."""

from collections.abc import Iterator

import numpy as np

from ffgym.agents import LFFC, SplineBasis
from ffgym.agents.coulomb_prior import STEEPNESS
from ffgym.agents.lffc import thesis_training
from ffgym.agents.tensor_bspline import POSITION_KNOTS
from ffgym.control import StaticLuGre
from ffgym.studies.one_axis import FREQUENCIES
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
    yield f"than its {path_mm('bsn_extended_prior', 100.0):.3f} mm over all positions, because"
    left = {(row["agent"], row["frequency_hz"]): 100 * row["reduction"] for row in numbers_of("networks")["one_axis"]}
    told = [f"{left[name, 1.0]:.1f} and {left[name, 3.0]:.1f} %" for name in ("bsn_static", "bsn_extended")]
    prior = f"{left['bsn_extended_prior', 1.0]:.1f} and {left['bsn_extended_prior', 3.0]:.1f} %"
    slow, fast = FREQUENCIES
    yield (
        f"(RMS error removed at {slow:g} Hz and {fast:g} Hz): static {told[0]}, extended {told[1]}, extended with "
        f"prior {prior}. At {fast:g} Hz the motor runs"
    )


@claim("ffgym.agents.SplineBasis")
def knots() -> Iterator[str]:
    """Knots of the splines of the thesis."""
    basis = SplineBasis()
    inner = np.abs(basis.knots) <= 1.0
    yield (
        f"have {basis.knots.size} knots, {inner.sum()} of them in +-1 rad/s, {(~inner).sum()} outside up to "
        f"+-{np.abs(basis.knots).max():g} rad/s, and order {basis.order} (hats)."
    )


@claim("ffgym.agents.lffc.thesis_training")
def training_of_networks() -> Iterator[str]:
    """Updates and rates of the networks of the catalogue."""
    robot, axis = (thesis_training(n_joints) for n_joints in (6, 1))
    slow, fast = FREQUENCIES
    yield (
        f"{robot.iterations} updates at p1 at 10 mm/s, gamma {robot.rate:g}; one axis: {axis.iterations} at "
        f"{slow:g} Hz, {axis.rate:g} |"
    )
    yield f"p1 at 10 and 40 mm/s; one axis: {slow:g} and {fast:g} Hz |"


@claim("ffgym.agents.coulomb_prior")
def width_of_the_prior() -> Iterator[str]:
    """Steepness of the step around standstill."""
    assert StaticLuGre.steepness == STEEPNESS
    yield f"u_c = f_c tanh({STEEPNESS:g} v) + constant"
    yield f"The {STEEPNESS:g} s/rad are those of static LuGre"


@claim("ffgym.agents.TensorBSN")
def weights_over_speed_and_position() -> Iterator[str]:
    """Weights of a network over speed and position."""
    yield f"nu_h are {POSITION_KNOTS} hats over it"
    yield f"A joint has {POSITION_KNOTS} x {SplineBasis().n_splines} weights."


@claim("ffgym.agents.LFFC")
def locks_of_networks() -> Iterator[str]:
    """When a joint is done."""
    yield f"`patience` {LFFC.patience} and `tolerance` {100 * LFFC.tolerance:g} % are ours"
