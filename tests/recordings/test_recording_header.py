import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recording_samples import header, json_dicts, json_values, read_or_refused, recordings, refused

from ffgym.core.errors import FFGymError
from ffgym.recordings import Header, Phase, Recording


@given(recordings())
def test_json_round_trip_gives_an_equal_header(recording: Recording) -> None:
    assert Header.from_json(recording.header.to_json()) == recording.header
    assert recording.header.to_json().isascii()


@given(json_values | json_dicts)
def test_any_other_json_is_refused_and_nothing_else_is_raised(values: Any) -> None:
    with pytest.raises(FFGymError):
        Header.from_json(json.dumps(values))


@given(st.sampled_from(list(header().__dict__)), json_values)
def test_any_value_in_any_field_gives_a_header_or_an_error(name: str, value: Any) -> None:
    values = {**json.loads(header().to_json()), name: value}
    with read_or_refused():
        read = Header.from_json(json.dumps(values))
        assert Header.from_json(read.to_json()) == read


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"schema_version": 2}, "header schema_version = 2 is not readable, must be 1"),
        ({"schema_version": True}, "schema_version = True"),
        ({"robot": ""}, "header robot must be non-empty text"),
        ({"joints": "j1"}, "header joints must be a tuple of text, got 'j1'"),
        ({"joints": ()}, "header joints = ()"),
        ({"joints": ("j1", "j1")}, "each once"),
        ({"joints": ("a,b", "c")}, "'a,b' must be letters"),
        ({"gear_ratio": (1.0,)}, "header gear_ratio has shape (1,), must be (2)"),
        ({"gear_ratio": (1.0, 0.0)}, "must not be zero"),
        ({"position_side": "arm"}, "Unknown header position_side 'arm'. Available: link, motor"),
        ({"torque_semantics": "Nm"}, "Unknown header torque_semantics"),
        ({"hold": "foh"}, "Unknown header hold"),
        ({"encoder_bits": 0}, "header encoder_bits = 0 must be an integer in [1, 64]"),
        ({"encoder_bits": 16.0}, "header encoder_bits = 16.0"),
        ({"filters": [1]}, "header filters must be a tuple of text"),
        ({"segment": None}, "header segment must be text"),
        ({"payload": {"com": [0, 0, 0]}}, "header payload has no mass"),
        ({"payload": {"mass": -1}}, "header payload mass = -1.0 kg is out of range"),
        ({"payload": {"mass": 1, "com": [0, 0]}}, "header payload com has shape (2,), must be (3)"),
        ({"payload": {"mass": 1, "size": 2}}, "Unknown header payload entry 'size'"),
        ({"units": {"motor.effort.j1": "N m"}}, "must be a user.<name> column"),
        ({"units": {"user.x": ""}}, "must be a user.<name> column"),
        ({"meta": {"x": float("nan")}}, "header meta must be JSON (no NaN, no objects)"),
        ({"meta": {"x": object()}}, "header meta must be JSON"),
        ({"provenance": [1]}, "header provenance must be a dict"),
        ({"phases": ("circle",)}, "header phases must be a tuple of Phase"),
    ],
)
def test_invalid_field_is_refused(change: dict[str, Any], message: str) -> None:
    with refused(message):
        header(**change)


def test_header_keeps_its_own_copies() -> None:
    meta = {"list": [1, 2], "seed": np.int64(3), "gains": np.array([1.5, 2.5])}
    copy = header(meta=meta)
    meta["list"] = "changed"
    assert copy.meta == {"list": [1, 2], "seed": 3, "gains": [1.5, 2.5]}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "The header is not valid JSON"),
        ("[" * 100_000, "The header is not valid JSON"),
        ("9" * 5000, "The header is not valid JSON"),
        ("[]", "The header must be a JSON object, got list"),
        ("{}", "header schema_version = None is not readable"),
        ('{"schema_version": 7, "future": 1}', "header schema_version = 7"),
        (
            '{"schema_version": 1, "robot": "r"}',
            "The header lacks joints, gear_ratio. Required: robot, joints, gear_ratio",
        ),
        (header().to_json()[:-1] + ', "motion": ""}', "Unknown header field 'motion'"),
        (header().to_json().replace("120.0", "9" * 400), "header gear_ratio must be numbers"),
        (header().to_json().replace('"phases": []', '"phases": [{"label": "a"}]'), "A phase must be an object with"),
        (header().to_json().replace('"phases": []', '"phases": 1'), "header phases must be a list"),
    ],
)
def test_damaged_json_is_refused(text: str, message: str) -> None:
    with refused(message):
        Header.from_json(text)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"label": ""}, "Phase label must be non-empty text"),
        ({"kind": "square"}, "Unknown kind of phase 'a': 'square'. Available: circle, lead_in"),
        ({"start": float("nan")}, "Phase 'a' start must be finite"),
        ({"end": 0.0}, "Phase 'a' ends at 0.0 s, must be after its start at 0.0 s"),
    ],
)
def test_invalid_phase_is_refused(change: dict[str, Any], message: str) -> None:
    with refused(message):
        Phase(**{"label": "a", "kind": "circle", "start": 0, "end": 1, **change})


def test_overlapping_phases_are_refused() -> None:
    first = Phase(label="a", kind="circle", start=0.0, end=2.0)
    second = Phase(label="b", kind="circle", start=1.0, end=3.0)
    with refused("Phase 'b' starts at 1.0 s, before 'a' ends at 2.0 s"):
        header(phases=(first, second))
