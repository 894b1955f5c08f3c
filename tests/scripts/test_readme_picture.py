"""The picture of the README: drawn from a simulation, whose errors the text of the picture names."""

import re
from pathlib import Path

import pytest

from scripts import readme_picture

ROOT = Path(__file__).parents[2]


def test_the_picture_is_drawn_from_a_simulation_with_the_errors_that_the_readme_names(tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    labels = []
    from matplotlib.axes import Axes

    plot = Axes.plot
    monkeypatch.setattr(
        Axes, "plot", lambda axes, *data, **look: labels.append(look["label"]) or plot(axes, *data, **look)
    )
    out = readme_picture.main(readme_picture.Config(out=tmp_path / "circle.svg"))
    assert out.read_text(encoding="utf-8").startswith("<?xml")
    errors = [re.search(r"RMS (\d+) µm", label)[1] for label in labels[:2]]
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert f"RMS {errors[0]} µm without compensation, {errors[1]} µm with dynamic LuGre" in readme
    assert (ROOT / "docs" / "pictures" / "circle.svg").stat().st_size < 100_000
