"""What docs/leaderboard/submissions.md tells of limits, tolerances and draws of a verification."""

from collections.abc import Iterator

import numpy as np

from ffgym.leaderboard.submission.drawn import MUCH
from ffgym.leaderboard.submission.judge import ACTION_TOLERANCE, SCORE_FLOOR_MM, SCORE_TOLERANCE
from ffgym.leaderboard.submission.manifest import LARGEST
from ffgym.leaderboard.submission.process import Limits
from ffgym.leaderboard.submission.rounds import RADII, SPEEDS, TILTS
from ffgym.paths import RADII as THESIS_RADII
from ffgym.robot import load_robot
from scripts.claims.claim import claim
from scripts.claims.told.constants import CODE


def power(value: float) -> str:
    """Write a power of ten as the page does."""
    return f"1e{np.log10(value):.0f}"


@claim(CODE)
def set_points_of_submissions() -> Iterator[str]:
    """Time between set-points."""
    yield f"one every {1e3 * load_robot('irb4600_60_205').servo.control_dt:g} ms: an action"


@claim(CODE)
def public_motions() -> Iterator[str]:
    """Radii of the public motions."""
    radii = ", ".join(f"{1e3 * radius:g}" for radius in THESIS_RADII)
    yield f"All radii of the thesis ({radii} mm) at p2"


@claim(CODE)
def ranges_of_a_draw() -> Iterator[str]:
    """Ranges that motions are drawn from."""
    low, high = np.rad2deg(TILTS)
    yield f"that is tilted by {low:.0f} to {high:.0f} degrees to any side"
    yield f"| {1e3 * RADII[0]:g} to {1e3 * RADII[1]:g} mm, uniform in the logarithm"
    yield f"| {1e3 * SPEEDS[0]:g} to {1e3 * SPEEDS[1]:g} mm/s, uniform in the logarithm"


@claim(CODE)
def memorised_submissions() -> Iterator[str]:
    """Public error below which a submission may be called memorised."""
    yield f"whose public error is below {MUCH:g} of that of `elastic`"


@claim(CODE)
def size_of_a_submission() -> Iterator[str]:
    """Largest file."""
    yield f"A ZIP file of at most {LARGEST / 2**20:.0f} MiB unpacked"


@claim(CODE)
def what_is_refused() -> Iterator[str]:
    """Sizes, tolerances and times of the checks."""
    dt = load_robot("irb4600_60_205").servo.control_dt
    yield f"larger than {LARGEST / 2**20:.0f} MiB, or holds"
    yield f"by more than {power(ACTION_TOLERANCE)} of the largest action"
    yield f"give errors more than {power(SCORE_TOLERANCE)} of them (and {power(SCORE_FLOOR_MM)} mm) off the claims"
    yield (
        f"is above the control step of {1e3 * dt:g} ms; or all decisions of a process, measured from outside, are more "
        f"than {Limits().late_s:g} s later"
    )


@claim(CODE)
def limits_of_a_process() -> Iterator[str]:
    """Memory and times of the agent's process."""
    limits = Limits()
    yield (
        f"limits of memory ({limits.memory_bytes / 2**30:.0f} GiB of address space), processor time "
        f"({limits.cpu_seconds / 60:.0f} minutes), time to be made ({limits.start_s / 60:.0f} minutes) and time per "
        f"decision ({limits.decision_s:g} s)"
    )
