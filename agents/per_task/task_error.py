"""What the recording of a trial says about its error, at the control samples of the reference."""

import numpy as np

from ffgym.agents.per_task.torque_response import Target
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths import Reference
from ffgym.recordings import Recording
from ffgym.recordings.metrics import motor_error, standstill_offset


def task_error(recording: Recording, reference: Reference, target: Target) -> Array:
    """Error, reference minus measured, at every sample of the reference, shape (T, m).

    Of motors [rad], motor side, m = N; or of the TCP [m], world, m = 3, without its offset at the first standstill.

    Raises:
        FFGymError: if the recording lacks what is asked, or is not of this reference.
    """
    if target == "motor":
        return at_samples(motor_error(recording), recording, reference)
    away = recording.vector("tcp.position") - recording.vector("tcp_reference.position")
    return at_samples(standstill_offset(recording) - away, recording, reference)


def at_samples(rows: Array, recording: Recording, reference: Reference) -> Array:
    """Weighted means (T, m) of recorded rows around each control sample; the weight falls to 0 one sample away.

    Symmetric, so that nothing is late. Rows with NaN, which a tracker did not see, lie on straight lines between their
    neighbours first.

    Raises:
        FFGymError: if the recording is not of this reference, or has no row that was seen.
    """
    per_sample = round(reference.robot.servo.control_dt / recording.dt)
    if len(rows) != (len(reference.t) - 1) * per_sample + 1:
        raise FFGymError(
            f"Recording {recording.header.segment!r} of {len(rows)} rows every {recording.dt:g} s is none of the "
            f"motion {reference.name!r}, which lasts {reference.duration:g} s."
        )
    seen = ~np.isnan(rows).any(axis=1)
    if not seen.any():
        raise FFGymError(f"Recording {recording.header.segment!r} has no row in which the TCP was seen.")
    if not seen.all():
        rows = np.stack([np.interp(recording.t, recording.t[seen], column[seen]) for column in rows.T], axis=1)
    weights = np.convolve(np.ones(per_sample), np.ones(per_sample)) / per_sample**2
    padded = np.pad(rows, ((per_sample - 1, per_sample - 1), (0, 0)), mode="edge")
    return np.stack([np.convolve(column, weights, mode="valid")[::per_sample] for column in padded.T], axis=1)


def circle_rms(error: Array, reference: Reference) -> dict[str, float]:
    """RMS length of the error (T, m) on each circle of the reference, by label; on the motion where it has none."""
    circles = [phase for phase in reference.phases if phase.kind == "circle"]
    if not circles:
        return {"motion": rms(error)}
    inside = {phase.label: (reference.t >= phase.start) & (reference.t < phase.end) for phase in circles}
    return {label: rms(error[rows]) for label, rows in inside.items()}


def rms(error: Array) -> float:
    """Root mean square over time of the length of the error (T, m)."""
    return float(np.sqrt((error**2).sum(axis=1).mean()))
