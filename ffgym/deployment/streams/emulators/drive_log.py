"""Log of an emulated drive: that of a stream, with the motor torque that a logger of the drive measures beside it."""

from dataclasses import replace

import numpy as np

from ffgym.deployment.streams.emulators.controller import EmulatedController
from ffgym.deployment.streams.recording import record_session
from ffgym.deployment.streams.session import StreamSession
from ffgym.recordings import Recording


def record_drive(session: StreamSession, controller: EmulatedController) -> Recording:
    """Make the recording of a session as `record_session` does, with `motor.effort` at the same instants.

    Raises:
        FFGymError: if the session sent nothing.
    """
    emulated = controller.robot
    log = record_session(session, emulated.robot)
    assert session.started_at is not None  # it sent something
    began = session.started_at - controller.start
    torque = emulated.torque_at(np.round((log.t + began) / emulated.cycle).astype(np.int64))
    columns = dict(log.columns) | {f"motor.effort.{joint}": torque[:, j] for j, joint in enumerate(log.header.joints)}
    return log.derive(columns, replace(log.header, torque_semantics="motor_side", hold="sampled"))
