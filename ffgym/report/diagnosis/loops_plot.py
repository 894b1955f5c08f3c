"""Friction of a motor over its speed: measured, and with and without the causes."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.residual import MotionResidual, Residual
from ffgym.report.diagnosis.joint_units import scale_of
from ffgym.report.diagnosis.models import LOOKS, NOMINAL, counting, motor_speed
from ffgym.report.figure import house_style, legend_above, new_figure
from ffgym.report.table import shortened

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def loops_figure(models: Mapping[str, Residual], joint: int, motions: Sequence[int]) -> "Figure":
    """One panel for each of `motions`, places in the log: torque without what the arm takes, over motor speed."""
    factor, unit = scale_of(models[NOMINAL].robot, "torque", joint)
    with house_style():
        figure = new_figure(3.1 * len(motions) + 0.5, 3.2)
        panels = figure.subplots(1, len(motions), squeeze=False)[0]
        for axes, place in zip(panels, motions, strict=True):
            nominal = models[NOMINAL].motions[place]
            rest = nominal.predicted["torque"][:, joint] - _friction(nominal, joint)
            lines = {"measured": nominal.measured["torque"][:, joint]}
            lines |= {name: residual.motions[place].predicted["torque"][:, joint] for name, residual in models.items()}
            for name, torque in lines.items():
                axes.plot(
                    motor_speed(nominal, joint), factor * counting(nominal, torque - rest), label=name, **LOOKS[name]
                )
            axes.set_title(shortened(nominal.motion), fontsize=8)
            axes.set_xlabel("motor speed [rad/s]")
        panels[0].set_ylabel(f"friction {'torque' if unit == 'N m' else 'force'} [{unit}]")
        legend_above(figure, *panels[0].get_legend_handles_labels())
    return figure


def loops_caption() -> str:
    """What is drawn."""
    return "Motor torque less what the nominal model gives apart from its friction (LuGre without bristle damping)."


def _friction(motion: MotionResidual, joint: int) -> Array:
    """Friction of the nominal model along a motion [N m], shape (R,)."""
    state = motion.state
    peak = (state.static - state.coulomb) * np.exp(-((state.motor_speed / state.stribeck_velocity) ** 2))
    friction: Array = ((state.coulomb + peak) * state.friction_sign + state.viscous * state.motor_speed)[:, joint]
    return friction
