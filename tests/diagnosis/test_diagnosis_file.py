"""`diagnosis.json`: what is written comes back, and what is damaged is refused by name."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.diagnosis_file import LEVELS, diagnosis_document, parse_diagnosis, read_diagnosis, write_diagnosis
from ffgym.diagnosis.result import Diagnosis
from tests.diagnosis.result_samples import full_diagnosis

PAGE = Path(__file__).parents[2] / "docs" / "diagnosis_json.md"


def test_a_diagnosis_comes_back_as_it_was_written(tmp_path):
    for diagnosis in (full_diagnosis(), Diagnosis(verdict="none", sentence="Nothing.", robot="r", motions=())):
        write_diagnosis(tmp_path / "diagnosis.json", diagnosis)
        assert read_diagnosis(tmp_path / "diagnosis.json") == diagnosis


def test_the_same_diagnosis_gives_the_same_bytes(tmp_path):
    for name in ("one.json", "two.json"):
        write_diagnosis(tmp_path / name, full_diagnosis())
    assert (tmp_path / "one.json").read_bytes() == (tmp_path / "two.json").read_bytes()


def test_levels_are_looked_up_by_channel_and_component():
    document = diagnosis_document(full_diagnosis())
    assert document["noise_floor"]["torque"]["j2"] == {"value": 0.012, "unit": "N m"}
    assert document["before"]["torque"]["j2"]["value"] == 0.09
    assert document["after"]["tool"]["x"]["value"] == 3e-6


def test_an_interval_that_nobody_knows_is_null_and_comes_back_as_such():
    full = full_diagnosis()
    unknown = replace(full.causes[0].parameters[0], interval=(-np.inf, np.nan))
    document = diagnosis_document(replace(full, causes=(replace(full.causes[0], parameters=(unknown,)),)))
    json.dumps(document, allow_nan=False)
    assert document["causes"][0]["parameters"][0]["interval"] == [None, None]
    assert np.isnan(parse_diagnosis(document).causes[0].parameters[0].interval).all()


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda d: d.pop("verdict"), "diagnosis lacks verdict"),
        (lambda d: d.update(verdict="certain"), "diagnosis.verdict = 'certain' must be one of none"),
        (lambda d: d["causes"][0].pop("joint"), r"diagnosis.causes\[0\] lacks joint"),
        (lambda d: d["causes"][0]["parameters"][0].update(value="much"), r"parameters\[0\].value = 'much' must be a"),
        (lambda d: d["causes"][0]["parameters"][0].update(interval=[1.0]), r"interval = \[1.0\] must be a list of 2"),
        (lambda d: d.update(cause="x"), "unknown entries cause"),
        (lambda d: d.update(rivals={}), "rivals = {} must be a list"),
        (lambda d: d["rivals"][0].update(tied=1), r"rivals\[0\].tied = 1 must be true or false"),
        (lambda d: d.update(separating_motion=3), "separating_motion = 3 must be an object"),
        (lambda d: d.update(format="ffgym-friction"), "no diagnosis"),
        (lambda d: d.update(version=2), "has version 2, this ffgym reads 1"),
        (lambda d: d.pop("after"), "must have measured, noise_floor, before, after"),
        (lambda d: d["after"]["torque"].pop("j2"), "the same channels and components"),
        (lambda d: d["after"]["torque"]["j2"].update(unit="mm"), "after.torque.j2 must have value and unit"),
        (lambda d: [d[level].update(heat={"x": {}}) for level in LEVELS], "channel 'heat'"),
    ],
)
def test_a_damaged_file_is_refused_with_the_place_of_the_damage(tmp_path, damage, message):
    document = diagnosis_document(full_diagnosis())
    damage(document)
    path = tmp_path / "damaged.json"
    path.write_text(json.dumps(document))
    with pytest.raises(FFGymError, match=message) as caught:
        read_diagnosis(path)
    assert str(caught.value).startswith(str(path))


@pytest.mark.parametrize("text", ["", "[1, 2", "[]", "null", '"text"', "{" * 100_000, '{"format": "ffgym-diagnosis"}'])
def test_what_is_no_diagnosis_gives_one_clear_error(tmp_path, text):
    path = tmp_path / "broken.json"
    path.write_text(text)
    with pytest.raises(FFGymError, match=r"broken\.json"):
        read_diagnosis(path)


@pytest.mark.parametrize("place", range(0, 2500, 97))
def test_a_file_that_was_cut_short_is_never_a_diagnosis(tmp_path, place):
    path = tmp_path / "cut.json"
    text = json.dumps(diagnosis_document(full_diagnosis()))
    path.write_text(text[: min(place, len(text) - 1)])
    with pytest.raises(FFGymError):
        read_diagnosis(path)


def entries(value, path=""):
    """Names of all entries of a document; those of lists and of channels stand under one name."""
    if isinstance(value, dict):
        for name, entry in value.items():
            yield from [f"{path}{name}", *entries(entry, f"{path}{name}.")]
    elif isinstance(value, list):
        for entry in value:
            yield from entries(entry, path)


def test_the_page_of_the_file_names_every_entry_and_no_other():
    document = diagnosis_document(full_diagnosis())
    for level in LEVELS:
        document[level] = {"<channel>": {"<component>": document[level]["torque"]["j2"]}}
    document["causes"][0]["fixed"], document["provenance"] = {}, {}
    rows = re.findall(r"^\| `([^`]+)` \|", PAGE.read_text(encoding="utf-8"), flags=re.M)
    wanted = list(dict.fromkeys(entries(document)))
    assert rows == [
        name for name in wanted if not re.fullmatch(r"(noise_floor|before|after)\..*|measured\.<channel>", name)
    ]
