"""Measurement protocols: motions that a machine makes to be identified, tested or diagnosed, and their recordings."""

from ffgym.protocols.catalogue import PROTOCOLS as PROTOCOLS
from ffgym.protocols.load import load_protocols as load_protocols
from ffgym.protocols.protocol import Protocol as Protocol
from ffgym.protocols.record import record as record
from ffgym.protocols.record import usual_sensors as usual_sensors
from ffgym.protocols.recording_folder import RecordedSession as RecordedSession
from ffgym.protocols.recording_folder import record_into as record_into
from ffgym.protocols.session import SessionMotion as SessionMotion
from ffgym.protocols.session import plan_session as plan_session
