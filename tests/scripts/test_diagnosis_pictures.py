"""Pictures of the page on diagnosis are drawn from residuals of any robot with two joints or more."""

import pytest

from scripts.diagnosis_pictures import drawn
from tests.diagnosis.residual_samples import made_up


def test_the_pictures_of_the_page_are_drawn(irb4600, tmp_path):
    pytest.importorskip("matplotlib")
    places = drawn(tmp_path, made_up(irb4600, {}), None)
    assert [place.name for place in places] == ["diagnosis_regimes.png", "diagnosis_depends.png"]
    assert all(place.read_bytes().startswith(b"\x89PNG") for place in places)
