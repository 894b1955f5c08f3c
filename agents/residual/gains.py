r"""Servo gains: a linear residual on a law, three numbers for all motors; what a learned feedback has to beat.

.. math:: r = \mathrm{clip}(a\, e + b\, \dot e + c\, r_{last}, -1, 1)

with the errors of `ffgym.agents.residual.composition.Features`, in tenths of f_s / K. It is a little more of the
servo's own gains behind a first-order filter, and learns nothing of machine or path.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ffgym.agents.declaration import AgentEntry, declare
from ffgym.agents.residual.actor import Actor, LinearLayer
from ffgym.agents.residual.bases import ACTION_SCALES
from ffgym.agents.residual.composition import per_motor
from ffgym.agents.residual.policy import ResidualPolicy, load_policy
from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array
from ffgym.leaderboard.comparison.standings import SERVO_GAINS as _NAMES

GAINS = _NAMES
"""Names of all rows of servo gains."""
SERVO_GAINS, SERVO_GAINS_DRIVES, SERVO_GAINS_STABLE = GAINS
"""Names of the rows: tuned on robots with ideal drives, on machines with real ones and other effects, and on these
machines by gains that have stability margins."""


def make_gains(
    gains: Sequence[float] | Array,
    *,
    n_motors: int,
    base: str = "elastic",
    bound: float = 0.6,
    meta: Mapping[str, Any] | None = None,
) -> ResidualPolicy:
    """Make a linear residual policy.

    Args:
        gains: gains a, b of position and speed error, and c of the last residual, which must be smaller than 1.
        n_motors: number of motors N.
        base: law below.
        bound: largest residual torque, in breakaway torques.
        meta: origin of the gains.

    Raises:
        FFGymError: if the gains are not three, or the filter grows.
    """
    values = check_shape("gains", gains, (3,))
    if not abs(values[2]) < 1:
        raise FFGymError(f"gains[2] = {values[2]:g} of the last residual must lie between -1 and 1: the filter grows.")
    weight = np.zeros((1, per_motor(1)))
    weight[0, :3] = values
    layer = LinearLayer(weight=weight, bias=np.zeros(1))
    actor = Actor(n_motors=n_motors, layers=(layer,), activation="relu", output="clip", factored=True)
    scale = ACTION_SCALES[base]
    return ResidualPolicy(
        base=base, machine=None, actor=actor, memory=1, bound=bound, action_scale=scale, meta=meta or {}
    )


_TUNED_ON = {
    SERVO_GAINS: ("servo gains on elastic", "robots drawn about the nominal one"),
    SERVO_GAINS_DRIVES: (
        "servo gains on elastic, drives",
        "machines with drives and effects drawn about the nominal one",
    ),
    SERVO_GAINS_STABLE: (
        "servo gains on elastic, stable",
        "machines with drives and effects drawn about the nominal one, among gains whose loop stays stable at twice "
        "the gain and with a sample of delay",
    ),
}
"""Titles, and plants that gains are tuned on."""

declare(
    *(
        AgentEntry(
            name=name,
            title=title,
            about="A linear residual on elastic feed-forward: position error, speed error and its own last value, "
            f"three numbers for all motors, tuned on {plants}. A learned feedback has to beat it.",
            track="causal, nominal parameters",
            order=19.5 + 0.1 * i,
            page="residual.md",
            load=lambda path, arm: load_policy(path),
            base="elastic",
            feedback=True,
        )
        for i, (name, (title, plants)) in enumerate(_TUNED_ON.items())
    )
)
