"""What docs/diagnosis_patterns.md and docs/diagnosis_tables.md tell of settings."""

from collections.abc import Iterator

from ffgym.diagnosis.patterns.periodic import LEAST_CYCLES, MOST_CYCLES
from ffgym.diagnosis.separation import WARMING
from ffgym.diagnosis.settings import PatternsSettings
from ffgym.diagnosis.tables.problem import MAX_SPREAD, RMS_SPREAD, SEARCH_DT
from ffgym.diagnosis.tables.ranking import FITS
from scripts.claims.claim import claim

CODE = "the code itself"


@claim(CODE)
def cycles_of_patterns() -> Iterator[str]:
    """Frequencies over the angle of a motor."""
    yield f"{LEAST_CYCLES:g} to {MOST_CYCLES:g} cycles per turn,"


@claim(CODE)
def settings_of_patterns() -> Iterator[str]:
    """Chunks, blocks and false alarms."""
    settings = PatternsSettings()
    yield f"chunks of {settings.block * settings.chunk} (half a second)"
    yield f"Each block of {settings.block} rows"
    yield f"gives {100 * settings.false_alarms:g} % of logs in which noise alone"
    yield f"explains less than {100 * settings.least_share:g} % of the component"


@claim(CODE)
def warming_of_separation() -> Iterator[str]:
    """Warming of a machine of unknown climate."""
    yield f"to warm up by {float(WARMING.rise[0]):g} K."


@claim(CODE)
def fit_of_tables() -> Iterator[str]:
    """Spreads, step and verdict of a fit to tables."""
    yield f"in units of {RMS_SPREAD:g} for RMS and {MAX_SPREAD:g} for largest errors"
    yield f"at a physics step of {1e3 * SEARCH_DT:g} ms"
    yield f"at least {100 * FITS:g} % of its RMS rows"
