"""Lessons made by hand, with a signal that is known."""

import numpy as np

from ffgym.agents.trials import Lesson
from ffgym.paths import Reference


def lesson(reference: Reference, signal, motor_dq=None, motor_ddq=None, moving=None) -> Lesson:
    """A lesson along `reference` at its own samples; speeds, accelerations and moving rows can be others."""
    rows = len(signal)
    zero = np.zeros_like(signal)
    return Lesson(
        reference=reference,
        t=np.arange(rows) * 0.001,
        q=reference.q[:rows],
        motor_dq=reference.motor_dq[:rows] if motor_dq is None else motor_dq,
        motor_ddq=reference.motor_ddq[:rows] if motor_ddq is None else motor_ddq,
        signal=signal,
        added=zero,
        error=zero,
        moving=np.ones(rows, dtype=np.bool_) if moving is None else moving,
    )
