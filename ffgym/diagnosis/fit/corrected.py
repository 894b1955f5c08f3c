"""Sizes without what replay and simulation of the same machine differ by.

A replay takes steps of its own, follows standing motors within a band, and knows motions through a low-pass. For the
nominal machine that difference is known and taken off every residual; a machine with an effect has another one, which
would be read as a part of the effect.
"""

from ffgym.diagnosis.exact import exact_recordings
from ffgym.diagnosis.failures import FAILED
from ffgym.diagnosis.fit.fit import Fit
from ffgym.diagnosis.fit.refine import fit
from ffgym.diagnosis.fit.setting import Setting
from ffgym.diagnosis.log import log_of
from ffgym.diagnosis.measured import residual_rows
from ffgym.diagnosis.replay import predicted, replay


def corrected(setting: Setting, found: Fit) -> Fit:
    """The same hypotheses, fitted once more to residuals without what replay and simulation of their machine differ by.

    As they are, where nothing was found, the machine cannot be simulated along the log's set-points or be fitted again,
    or no more would be explained.
    """
    log, machine = setting.log, found.run.machine
    if not found.hypotheses:
        return found
    try:
        exact = exact_recordings(log, found.run)
        if not exact.simulated:
            return found
        own = log_of(log.robot, exact.recordings, like=log)
        bias = residual_rows(own, predicted(replay(own, machine)))
        again = fit(setting.with_bias(bias), found.hypotheses, begun=True)
    except FAILED:
        return found
    return again if again.left < found.left else found
