"""Recordings for the tests: a small fixed one, and a strategy for arbitrary ones."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st

from ffgym.core.errors import FFGymError
from ffgym.recordings import FAMILIES, PHASE_KINDS, Header, Phase, Recording
from ffgym.recordings.schema import VALID

JOINTS = ("j1", "j2")


def header(**changes: Any) -> Header:
    values: dict[str, Any] = {"robot": "two_axis", "joints": JOINTS, "gear_ratio": (120.0, -98.5)}
    return Header(**{**values, **changes})


def columns(n_rows: int = 5) -> dict[str, Any]:
    t = 0.004 * np.arange(n_rows)
    names = [*FAMILIES["motor.position"].columns(JOINTS), *FAMILIES["tcp.position"].columns(JOINTS)]
    return {"timestamp": t, **{name: i + np.sin(t) for i, name in enumerate(names)}}


def recording(n_rows: int = 5, **changes: Any) -> Recording:
    return Recording(columns(n_rows), header(**changes))


def refused(message: str) -> Any:
    """Expect an FFGymError of one line that holds `message`."""
    return pytest.raises(FFGymError, match=rf"\A[^\n\r]*{re.escape(message)}[^\n\r]*\Z")


@contextmanager
def read_or_refused() -> Iterator[None]:
    """Let an FFGymError of one line pass; any other exception is a failure."""
    try:
        yield
    except FFGymError as error:
        if len(str(error).splitlines()) != 1:
            raise AssertionError(f"not one line: {error}") from error


text = st.text('aé∂😀\ud800\0\u2028\n\r\t ,;#"\\{}_', max_size=8)
"""What files and JSON may trip over; a fixed alphabet needs no table of all of Unicode, which is slow to make."""

json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | text,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(text, inner, max_size=3),
    max_leaves=5,
)
json_dicts = st.dictionaries(text, json_values, max_size=3)


@st.composite
def phases(draw: Any, times: list[float]) -> tuple[Phase, ...]:
    """Phases in order, some touching and some apart, with borders on and between the rows."""
    borders = draw(st.lists(st.sampled_from(times) | st.floats(times[0], times[-1]), max_size=6, unique=True))
    pairs = list(pairwise(sorted(borders)))
    kept = [pair for pair in pairs if draw(st.booleans())]
    kinds = st.sampled_from(PHASE_KINDS)
    return tuple(Phase(label=draw(text.filter(bool)), kind=draw(kinds), start=a, end=b) for a, b in kept)


@st.composite
def recordings(draw: Any) -> Recording:
    """Any valid recording of a few rows: denormals, -0.0, NaN where it is allowed, free text and JSON."""
    joints = tuple(draw(st.lists(st.text("aZ09_/-", min_size=1, max_size=4), min_size=1, max_size=3, unique=True)))
    times = sorted(draw(st.lists(st.floats(-1e11, 1e11), min_size=2, max_size=6, unique=True)))
    families = draw(st.lists(st.sampled_from(list(FAMILIES.values())[1:]), max_size=4, unique=True))
    table: dict[str, Any] = {"timestamp": times}
    for family in families:
        values = st.floats(allow_infinity=False, allow_nan=family.may_miss)
        if family.name == VALID:
            values = st.sampled_from([0.0, 1.0])
        for name in family.columns(joints):
            table[name] = draw(st.lists(values, min_size=len(times), max_size=len(times)))
    units = draw(
        st.dictionaries(st.text("aZ09_./-", min_size=1, max_size=8).map("user.".__add__), st.just("1"), max_size=2)
    )
    table |= {name: np.arange(len(times)) for name in units}
    ratios = st.lists(st.floats(0.5, 500.0), min_size=len(joints), max_size=len(joints))
    return Recording(
        table,
        Header(
            robot=draw(text.filter(bool)),
            joints=joints,
            gear_ratio=tuple(draw(ratios)),
            torque_semantics=draw(st.sampled_from(["motor_side", "current", "unspecified"])),
            hold=draw(st.sampled_from(["linear", "zoh", "sampled"])),
            encoder_bits=draw(st.none() | st.integers(1, 64)),
            filters=tuple(draw(st.lists(text, max_size=2))),
            payload=draw(st.sampled_from([None, {"mass": 2.5}, {"mass": 60, "com": [0, 0, 0.1]}])),
            segment=draw(text),
            phases=draw(phases(times)),
            units=units,
            provenance=draw(json_dicts),
            meta=draw(json_dicts),
        ),
    )
