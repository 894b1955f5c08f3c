"""One training for several seeds."""

import pytest

from ffgym.core.errors import FFGymError
from ffgym.core.executors import Executor
from scripts.train import Sweep, main, train_one
from tests.agents.residual.residual_samples import SMALL


def test_each_seed_has_a_folder_and_what_is_done_is_not_done_again(tmp_path, capsys):
    config = Sweep(seeds=(3, 5), out=tmp_path, base="none", steps=16, set=SMALL["ppo"])
    folders = main(config)
    assert [folder.name for folder in folders] == ["seed_3", "seed_5"]
    written = [(folder / "policy.npz").stat().st_mtime_ns for folder in folders]
    assert main(config) == folders
    assert written == [(folder / "policy.npz").stat().st_mtime_ns for folder in folders]
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(":")[0] for line in lines] == ["seed 3", "seed 5"] * 2
    assert lines[:2] == lines[2:]


@pytest.mark.slow
def test_seeds_side_by_side_give_the_same_policies(tmp_path):
    for name, jobs in (("one", 1), ("two", 2)):
        options = {"base": "none", "steps": 16, "set": SMALL["ppo"], "executor": Executor(jobs=jobs)}
        main(Sweep(seeds=(3, 5), out=tmp_path / name, **options))
    for seed in (3, 5):
        one, two = ((tmp_path / name / f"seed_{seed}" / "policy.npz").read_bytes() for name in ("one", "two"))
        assert one == two


def test_what_makes_no_sweep_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    refused = (
        ({}, "--out FOLDER"),
        ({"out": tmp_path / "new", "seeds": (1, 1)}, "different numbers"),
        ({"out": tmp_path / "new", "seeds": (-1,)}, "seed = -1"),
        ({"out": tmp_path / "new", "reward": "best"}, "Unknown reward 'best'"),
        ({"out": tmp_path / "file"}, "file: cannot be made a folder: File exists"),
    )
    for options, message in refused:
        with pytest.raises(FFGymError, match=message):
            main(Sweep(**options), run=train_one)
        assert [place.name for place in tmp_path.iterdir()] == ["file"]
