"""Predicted beside measured torque of the KR 300; needs the published recordings, see FFGYM_DATA."""

import json
import os
from pathlib import Path

import pytest

from ffgym.core.errors import FFGymError
from scripts.torque_table import Config, main

PAGE = Path(__file__).parents[2] / "docs" / "torque_prediction.md"

needs_data = pytest.mark.skipif(
    not os.environ.get("FFGYM_DATA"), reason="set FFGYM_DATA to the folder with the published recordings"
)

LARGEST_SHARE = {"a1": 0.25, "a2": 0.15, "a3": 0.12, "a4": 0.65, "a5": 0.35, "a6": 0.30}
"""RMS error over RMS torque. On the main axes the torque ripple of the gearboxes is left; on the wrist, breakaway after
a rest and Coulomb friction that the authors identified too small for axes 4 and 5. Nothing is fitted."""


@needs_data
@pytest.mark.parametrize("run", ["A", "C"])
def test_published_numbers_predict_the_measured_torque(run, capsys):
    prediction = main(Config(run=run))
    for name in ("description", "published friction"):
        for error in prediction.errors(name):
            assert error.share < LARGEST_SHARE[error.joint], (run, name, error)
            assert abs(error.mean_error) < 0.35 * error.rms_measured
    assert "| a2 |" in capsys.readouterr().out


@needs_data
@pytest.mark.parametrize("run", ["A", "C"])
def test_the_counterbalance_is_needed_on_axis_2(run):
    prediction = main(Config(run=run))
    with_spring, without = (prediction.errors(name)[1] for name in ("published friction", "without springs"))
    assert without.rms_error > 4 * with_spring.rms_error


@needs_data
@pytest.mark.parametrize("run", ["A", "C"])
def test_the_table_of_the_page_is_current(run, tmp_path):
    copy = tmp_path / "page.md"
    copy.write_text(PAGE.read_text(encoding="utf-8"), encoding="utf-8")
    main(Config(run=run, write=copy))
    assert copy.read_text(encoding="utf-8") == PAGE.read_text(encoding="utf-8")


@needs_data
def test_it_draws_and_writes_what_is_asked_for(tmp_path):
    main(Config(figure=tmp_path / "torque.png", json=tmp_path / "torque.json"))
    assert (tmp_path / "torque.png").stat().st_size > 10_000
    numbers = json.loads((tmp_path / "torque.json").read_text(encoding="utf-8"))
    assert [error["joint"] for error in numbers["errors_nm"]["description"]] == ["a1", "a2", "a3", "a4", "a5", "a6"]


def test_without_the_recordings_it_is_one_clear_error(monkeypatch):
    monkeypatch.delenv("FFGYM_DATA", raising=False)
    with pytest.raises(FFGymError, match="FFGYM_DATA"):
        main(Config())
