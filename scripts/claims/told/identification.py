"""What docs/identification.md tells of the settings of its fits, and of the coverage that its tables show."""

import re
from collections.abc import Iterator

import numpy as np
import scipy

from ffgym.core.files import read_text
from ffgym.diagnosis.resampling import LEVEL
from ffgym.diagnosis.settings import settings
from ffgym.robot import load_robot
from scripts.claims.claim import claim
from scripts.claims.page import ROOT
from scripts.claims.records import numbers_of
from scripts.claims.told.constants import CODE, default
from scripts.tables.friction import ANGLE_NOISE, BEFORE, INERTIA_ERROR, JOINTS, NOISE, REPETITIONS, coverage

PAGE = ROOT / "docs" / "identification.md"
AGAIN = "python -m scripts.tables --page identification.md"


@claim(CODE)
def filter_of_friction() -> Iterator[str]:
    """Low-pass of angle and torque."""
    cutoff = settings().sampling.motion_cutoff
    yield f"The default is {cutoff:g} Hz (`--cutoff-hz`); logs sampled at less than {2 * cutoff:g} Hz need a lower one."


@claim(CODE)
def windows_of_friction() -> Iterator[str]:
    """Length of windows of constant speed."""
    yield f"Windows of {settings().friction.speed_window:g} s in which speed does not change"


@claim(CODE)
def starts_of_bristles() -> Iterator[str]:
    """Starts of the fit of bristles."""
    yield f"{settings().friction.starts} random starts of which the best"


@claim(CODE)
def nuisances_of_friction() -> Iterator[str]:
    """Priors and bounds of what is fitted beside the bristles."""
    fit = settings().friction
    yield f"by a common share | bound {100 * fit.inertia_error:g} % |"
    yield f"are told apart by it | {100 * fit.link_error:g} %, {100 * fit.inertia_error:g} % |"
    yield f"by a share of the stiffness | {100 * fit.spring_error:g} %, {100 * fit.inertia_error:g} % |"
    yield f"of the whole modelled torque | {1e3 * fit.delay:g} ms, {1e3 * fit.longest_delay:g} ms |"


@claim(CODE)
def priors_of_shares() -> Iterator[str]:
    """What is known of stiffness and delay before the share is fitted."""
    fit = settings().friction
    yield f"or else {100 * fit.spring_error:g} %, and the interval of s carries it"
    yield f"d is fitted, with a prior of {1e3 * fit.delay:g} ms."


@claim(CODE)
def resamples_of_friction() -> Iterator[str]:
    """Blocks that are drawn again."""
    fit = settings().friction
    yield f"({fit.speed_window:g} s of constant speed, {fit.block:g} s of reversals)"


@claim(CODE)
def wide_friction() -> Iterator[str]:
    """Half width from which an interval is wide."""
    yield f"*wide* (half width above {100 * settings().friction.wide:g} %)"


@claim(CODE)
def how_coverage_is_counted() -> Iterator[str]:
    """Machine, noise and repetitions behind the tables."""
    off = [100 * abs(factor - 1) for factor in BEFORE.values()]
    (repetitions,) = set(REPETITIONS.values())
    (bits,) = {load_robot(name).sensors.encoder_bits for name in REPETITIONS}
    yield f"with other friction ({min(off):.0f} to {max(off):.0f} % off) and {100 * INERTIA_ERROR:g} % less inertia"
    yield (
        f"at {1e3 * default(coverage, 'record_dt'):g} ms, {bits} bit, torque noise of {100 * NOISE:g} % of the peak "
        f"torque at each sample, angle noise of {ANGLE_NOISE:g} encoder steps, {repetitions} repetitions;"
    )
    low, high = scipy.stats.binom.interval(LEVEL, repetitions, LEVEL)
    yield f"In {repetitions} repetitions an interval that is right holds it {low:.0f} to {high:.0f} times"


@claim(AGAIN)
def coverage_of_intervals() -> Iterator[str]:
    """Means of the coverage in both tables."""
    shares = np.array([list(map(int, re.findall(r", (\d+)% \|", line))) for line in read_text(PAGE).splitlines()
                       if re.match(r"\| j\d", line)])  # fmt: skip
    assert shares.shape == (1 + len(JOINTS["irb4600_60_205"]), 6)
    yield f"hold the truth in {shares.mean():.0f} % of the cases"
    yield f"whose intervals hold it in {shares[:, 4:].mean():.0f} %:"


@claim("python -m scripts.claims --record session")
def limits_of_friction() -> Iterator[str]:
    """Physics step of the tables' records, and an interval on the workcell."""
    yield f"simulated at {1e3 * default(coverage, 'physics_dt'):g} ms."
    (found,) = [
        each
        for each in numbers_of("session")["parameters"]
        if (each["joint"], each["name"]) == ("j1", "friction.coulomb")
    ]
    low, high = found["interval"]
    yield f"f_c of joint 1 comes out as {found['value']:.4f} N m, {low:.4f} to {high:.4f} ([record]"
