"""Logs that ship with the package, so that a diagnosis can be tried at once."""

from importlib import resources

from ffgym.recordings import Recording
from ffgym.recordings.npz import decode

EXAMPLE_ROBOT = "irb4600_60_205"
"""Nominal model of the machine that the logs are of."""


def example_logs() -> list[Recording]:
    """The first recording of a machine that its model describes but for two faults, in the order of the session.

    `scripts/example_logs.py` makes them, on a machine of the workcell's kind.
    """
    files = (resources.files("ffgym.diagnosis") / "data").iterdir()
    logs = [decode(file.read_bytes()) for file in files if file.name.endswith(".npz")]
    return sorted(logs, key=lambda log: float(log.header.meta["session_start"]))
