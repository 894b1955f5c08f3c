"""How often a residual repeats in a turn of a motor, for whoever looks for the period of an effect."""

import numpy as np

from ffgym.core.errors import check_choice
from ffgym.diagnosis.patterns.periodic import Amplitude, PerTurn
from ffgym.diagnosis.patterns.rows import rows_of
from ffgym.diagnosis.patterns.spectrum import Spectrum
from ffgym.diagnosis.residual import Channel, Residual, components


def cycles_per_turn(
    residual: Residual, channel: Channel, component: str, joint: str, *, amplitude: Amplitude = "constant"
) -> Spectrum | None:
    """Periodogram of one component of a residual over the motor angle of a joint, 0.5 to 72 cycles per turn.

    Frequencies are a quarter of the resolution apart, which is one over the turns that the motor makes in all.

    Args:
        residual: what a model leaves.
        channel: which of its channels.
        component: joint or axis of the channel.
        joint: whose motor turns.
        amplitude: what the amplitude goes with.

    Returns:
        None where there are no rows, or the motor turns too little for any period.

    Raises:
        FFGymError: if there is no such channel, component or joint.
    """
    check_choice("channel", channel, residual.channels)
    names = components(channel, residual.robot)
    check_choice("component", component, names)
    check_choice("joint", joint, residual.robot.joints)
    rows = rows_of(residual, channel, np.random.default_rng(0))  # halves are not used
    if rows is None:
        return None
    values = rows.values[:, names.index(component)]
    everything = np.ones(len(values), dtype=np.bool_)
    spectra = PerTurn(joint=rows.joints.index(joint), amplitude=amplitude).spectra(rows, values[:, None], everything)
    return None if spectra is None else spectra[0]
