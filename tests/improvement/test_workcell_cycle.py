"""Acceptance on the workcell: a model that is found from its recordings alone compensates where none was made."""

import json

import pytest

from ffgym.cli.main import main
from ffgym.improvement.gain import BASELINE, FITTED, MODEL


@pytest.mark.slow
def test_feed_forward_of_the_diagnosed_model_takes_most_of_the_path_error_off_dynamic_lugre(tmp_path, capsys):
    arguments = [
        "improve",
        "--rig",
        "workcell:thesis",
        "--fit",
        "--rounds",
        "1",
        "--positions",
        "p2",
        "--radii-mm",
        "5",
    ]
    assert main([*arguments, "--out", str(tmp_path)]) == 0
    scores = json.loads((tmp_path / "improvement.json").read_text(encoding="utf-8"))["scores"]
    left = {(score["law"], score["speed_mm_s"]): score["rms_um"] for score in scores}
    for speed in (10.0, 40.0, 100.0):
        assert left[FITTED, speed] < 0.5 * left[BASELINE, speed]
        assert left[MODEL, speed] < 0.5 * left[BASELINE, speed]
    assert "smaller on 3 of 3 circles" in " ".join(capsys.readouterr().out.split())
    assert all((tmp_path / name).stat().st_size > 10_000 for name in ("laws.png", "paths.png", "improvement.html"))
