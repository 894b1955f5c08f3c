r"""Several effects by which the output of one gearbox leads its motor, as waves of its kinematic error.

Outputs that lead by :math:`e_i(\theta)` wind the spring by torques :math:`\tau_i`. What acts back on the motor is the
whole load times the slope of all of them,

.. math:: -(\tau_l + \sum_i \tau_i) \sum_j \partial e_j / \partial \theta

of which each effect by itself knows :math:`-(\tau_l + \tau_i)\, \partial e_i / \partial \theta`. The rest is here:
without it, two waves would make energy that one wave of the same shape does not.
"""

from ffgym.core.types import Array, BoolArray
from ffgym.effects.effect import TorqueEffect
from ffgym.effects.state import State


class Leads:
    """What effects add on the motors because of one another, told as they come one after the other."""

    def __init__(self, *, are_in_load: bool) -> None:
        """None yet; `are_in_load` if the load that an effect sees has in it what those before wind the spring by."""
        self._are_in_load = are_in_load
        self._before: tuple[Array, Array] | None = None

    def beside(
        self, effect: TorqueEffect, state: State, spring: Array | None, present: BoolArray | None = None
    ) -> Array | None:
        """What one more effect makes of those before it, motor side [N m], (..., N); None is nothing.

        It winds the spring by `spring` [N m], link side, of the machines that are `present`. Only effects by which
        outputs lead count.
        """
        slope = effect.lead_slope(state)
        if slope is None or spring is None:
            return None
        if present is not None:
            slope, spring = slope * present, spring * present
        if self._before is None:
            self._before = (spring, slope)
            return None
        springs, slopes = self._before
        self._before = (springs + spring, slopes + slope)
        return -spring * slopes if self._are_in_load else -spring * slopes - springs * slope
