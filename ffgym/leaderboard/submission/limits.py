"""What an agent of others may use of time and memory."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What an agent may use; chosen so that honest ones never meet them."""

    start_s: float = 120.0
    """Time to load it, with libraries [s]."""
    decision_s: float = 20.0
    """Time of one decision, for all robots of a run [s]; what is usual is measured apart."""
    late_s: float = 10.0
    """Time that all decisions of a run may take beyond one control step for each decision of each robot [s]: the first
    ones of libraries take long, and computers do other things. It bounds how long a run may take."""
    memory_bytes: int = 32 * 2**30
    """Address space: libraries reserve much more than they use."""
    cpu_seconds: int = 1800
    """Of one process, all threads together [s]."""
