import numpy as np
import pytest

from ffgym.agents.entrants import ENTRANTS, REGISTRY
from ffgym.core.errors import FFGymError
from ffgym.core.executors import Executor
from ffgym.leaderboard.board import Board
from ffgym.leaderboard.plants import THESIS_WORKCELL
from ffgym.leaderboard.results import read_row
from scripts.workcell_oracle import Config, main
from tests.processes import held_elsewhere


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Results with the oracle on the workcell."""
    place = tmp_path_factory.mktemp("oracle")
    main(Config(out=place, splits=("speeds",)))
    return place


def test_the_oracle_leaves_little_more_than_the_noise_of_the_tracker_and_tells_no_truth(folder):
    [outcome] = read_row(folder / "oracle.json").outcomes
    assert outcome.plant == THESIS_WORKCELL
    assert np.median([cell.rms_mm for cell in outcome.cells]) < 0.015  # 0.01 mm of noise in each coordinate
    text = (folder / "oracle.json").read_text()
    assert not [word for word in ("friction", "stiffness", "slip_elements", "amplitude") if f'"{word}' in text]


def test_the_command_keeps_it_and_does_not_ask_for_it_again(folder):
    board = Board(registry=REGISTRY, folder=folder)
    assert board.run([ENTRANTS["oracle"]], [THESIS_WORKCELL], ["speeds"], 1, Executor(jobs=1)) == 0
    assert len(board.rows["oracle"].outcomes) == 1


def test_a_folder_that_is_being_filled_is_left_alone(folder):
    before = (folder / "oracle.json").read_bytes()
    with held_elsewhere(folder), pytest.raises(FFGymError, match=r"process \d+ .* is writing there"):
        main(Config(out=folder, splits=("radii",)))
    assert (folder / "oracle.json").read_bytes() == before
