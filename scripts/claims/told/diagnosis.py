"""What docs/diagnosis.md tells of the settings of a diagnosis, and of the example logs."""

import re
from collections.abc import Iterator
from itertools import takewhile

from ffgym.diagnosis.result import SMALL
from ffgym.diagnosis.settings import settings
from ffgym.logs.quality.wiring.search import LEAST_DELAY, LEAST_ROWS
from scripts.claims.claim import claim
from scripts.claims.records import numbers_of
from scripts.claims.told.constants import CODE

AXES = 6
"""Axes of the robots that the page speaks of."""


@claim(CODE)
def default_calibration() -> Iterator[str]:
    """How well nominal numbers are known if nobody says."""
    yield f"({settings().prior.share:g} is half a percent, one standard deviation)"


@claim(CODE)
def band_of_a_diagnosis() -> Iterator[str]:
    """Low-passes, and the steps of springs."""
    sampling = settings().sampling
    yield f"without delay ({sampling.motion_cutoff:g} Hz at most)"
    shortest = sampling.rows_of_short_log / (sampling.rows_per_period * sampling.cutoff)
    yield f"symmetric low-pass ({sampling.cutoff:g} Hz at most,"
    yield f"up to {sampling.motion_cutoff:g} Hz if all motions together last less than {shortest:g} s)"


@claim(CODE)
def least_delay_of_wiring() -> Iterator[str]:
    """From what delay on a torque is of another time."""
    yield f"late by less than {1e3 * LEAST_DELAY:g} ms, or {LEAST_ROWS:g} rows if those are longer"


@claim(CODE)
def steps_of_springs() -> Iterator[str]:
    """Longest step of springs."""
    yield f"in steps of {1e3 * settings().replay.spring_step:g} ms at most"


@claim(CODE)
def band_of_rigid_joints() -> Iterator[str]:
    """Lowest cut-off."""
    yield f"times the bandwidth of the motion, {settings().sampling.lowest_cutoff:g} Hz at least"


@claim(CODE)
def noise_floor_of_a_diagnosis() -> Iterator[str]:
    """What counts as noise, and how late columns may be."""
    noise = settings().noise
    yield f"vibration above {settings().sampling.cutoff:g} Hz left out"
    yield f"explain to {100 * (1 - settings().replay.servo_leaves):g} % with any gains"
    yield f"rows {1e3 * noise.reversal_time:g} ms apart"
    yield f"{1e3 * noise.reversal_time * noise.reversals_between_rows:g} ms and more none"
    yield f"a quarter of a cycle, {1e3 * settings().prior.friction_lag:g} ms)"


@claim(CODE)
def numbers_that_are_fitted_first() -> Iterator[str]:
    """From what uncertainty on numbers are fitted before a search."""
    yield f"known to {100 * settings().prior.loose:g} % or worse"


@claim(CODE)
def how_causes_are_found() -> Iterator[str]:
    """Thresholds of the search."""
    setting, search, rivals = settings().significance, settings().search, settings().rivals
    yield f"standard deviation ({100 * settings().prior.share:g} % unless the caller knows better)"
    yield f"Numbers that are known to {100 * settings().prior.loose:g} % or worse are fitted first"
    yield f"runs over {settings().screening.surrogates} logs without fault"
    floor = f"{100 * setting.floor:g} %"
    yield f"and {floor} of all energy there, noise included, is adopted; what is above the noise must be {floor}, too."
    yield f"removes {100 * setting.mostly:g} % of all energy there"
    yield f"if one of its sizes is {100 * setting.sizeable:g} % of its plausible range or more"
    yield f"but for {100 * search.needed:g} % of all energy, is dropped"
    yield f"{100 * setting.leaks:g} % of what the loudest component of a channel still has above the noise"
    yield f"for which no size reaches {100 * setting.sizeable:g} % of its plausible range"
    yield f"in {100 * rivals.tied:g} % of resamples ties with it"
    yield f"but for {100 * rivals.alike:g} % of what is above the noise"
    yield f"({100 * rivals.unsure_floor:g} % of the noise are always open)"


@claim(CODE)
def verdict_named() -> Iterator[str]:
    """What causes remove to be named."""
    yield f"at least {100 * settings().verdict.named:g} % of the energy above the noise"


@claim(CODE)
def how_sizes_are_known() -> Iterator[str]:
    """What is open of a size."""
    yield f"and {100 * settings().intervals.inexact:g} % of the size for a model that is inexact"


@claim(CODE)
def how_long_logs_may_be() -> Iterator[str]:
    """Seconds of all axes that a diagnosis can afford at some sample rates [Hz], and the length of a stretch."""
    blocks = settings().blocks
    fast, usual = (blocks.samples / AXES / rate for rate in (1000, 250))
    slow = blocks.rows / AXES / 100  # each sample is a row
    yield f"A diagnosis can afford {fast:g} s of six axes at 1 kHz, {usual:g} s at 250 Hz, or {slow:g} s at 100 Hz,"
    yield f"to stretches of about {blocks.stretch * blocks.cell:g} s"


@claim(CODE)
def what_counts_as_small() -> Iterator[str]:
    """Share of what was measured that is small."""
    yield f"or {100 * SMALL:g} % of what was measured)"


@claim("python -m scripts.claims --record example_diagnosis")
def answer_of_the_example_logs() -> Iterator[str]:
    """What is printed of the example logs."""
    record = numbers_of("example_diagnosis")
    yield f"logs of {record['duration_s']:.0f} s of a machine"
    yield record["printed"][0]
    heading = next(k for k, line in enumerate(record["printed"]) if line.startswith("joint "))
    for line in takewhile(lambda line: not line.startswith("held out:"), record["printed"][heading + 1 :]):
        cells = re.split(r"\s+\|\s+|\s{2,}", line)
        yield f"| {' | '.join(cell for cell in cells if cell)} |"
