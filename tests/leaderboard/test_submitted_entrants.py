"""Submissions on the leaderboard, beside the agents of the package."""

import gc

import pytest

from ffgym.agents.entrants import REGISTRY, make_submitted
from ffgym.cli.main import main
from ffgym.control import ObservationLayout
from ffgym.core.errors import FFGymError
from ffgym.core.executors import Executor
from ffgym.leaderboard.board import Board
from ffgym.leaderboard.entrants import Registry, find_entrants
from ffgym.leaderboard.evaluation.closed_loop import environment_for
from ffgym.leaderboard.plants import find_plant
from ffgym.leaderboard.results import read_row
from ffgym.leaderboard.submission.manifest import AgentSource
from tests.leaderboard.submission_samples import agent_file, changed, packed
from tests.processes import is_alive, waited

AFRAID = "if len(observation) > 1: raise RuntimeError('too many')"
"""What nobody notices where one circle is run."""


@pytest.fixture(scope="module")
def law(tmp_path_factory):
    """File of a submission: dynamic LuGre under another name."""
    place = tmp_path_factory.mktemp("submission") / "mine.zip"
    place.write_bytes(
        changed(packed(AgentSource(kind="law", law="lugre_dynamic")).data, manifest={"robot_seconds": 7.0})
    )
    return place


def test_a_submission_gets_a_row_like_that_of_the_law_in_it(law, tmp_path, capsys):
    command = ["leaderboard", "--agents", "lugre_dynamic", str(law), "--plants", "nominal", "--splits", "speeds"]
    assert main([*command, "--jobs", "1", "--out", str(tmp_path)]) == 0
    assert " mine " in capsys.readouterr().out
    mine, own = (read_row(tmp_path / f"{name}.json") for name in ("mine", "lugre_dynamic"))
    assert (mine.title, mine.track, mine.ranked) == ("an agent of mine", "causal, nominal parameters", False)
    assert "Submitted by somebody, who claims 7 s of robot time in training; not ranked" in mine.about
    [theirs], [ours] = mine.outcomes, own.outcomes
    assert {cell.key: cell.rms_mm for cell in theirs.cells} == pytest.approx(
        {cell.key: cell.rms_mm for cell in ours.cells}, rel=1e-4
    )
    assert theirs.artefact == make_submitted(law).artefact("nominal", 0)
    assert theirs.inference_us > 0
    assert theirs.robot_seconds == 0.0

    assert main(["leaderboard", "--agents", "none", *command[4:], "--jobs", "1", "--out", str(tmp_path)]) == 0
    assert "not shown: mine is no agent of this leaderboard" in capsys.readouterr().out


@pytest.mark.slow
def test_other_processes_find_it_too(law):
    board = Board(registry=Registry(REGISTRY.known, REGISTRY.maker, (str(law),)))
    every = find_entrants(board.registry)
    board.run([every["none"], every["mine"]], ["nominal", "draw:0"], ["speeds"], 1, Executor(jobs=2))
    assert [outcome.plant for outcome in board.rows["mine"].outcomes] == ["nominal", "draw:0"]


def test_its_process_ends_when_nobody_asks_it_any_more(law):
    plant = find_plant("nominal")
    [ready] = make_submitted(law).ready(plant, [0], ())
    env = environment_for(plant, ready.policy.preview, ready.policy.action_scale, 1, n_threads=1)
    layout = env.unwrapped.observation_layout
    assert isinstance(layout, ObservationLayout)
    agent = ready.policy.agent(plant.rig.robot, layout)
    pid = agent._process.pid
    env.close()
    assert is_alive(pid)
    del agent
    gc.collect()
    assert waited(lambda: not is_alive(pid))


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (
            lambda: packed(content=agent_file(AFRAID)).data,
            "'mine' was ended: refused, agent: it raised RuntimeError: too",
        ),
        (lambda: changed(packed().data, files={"agent.py": agent_file(AFRAID)}), "weights were changed"),
    ],
)
def test_an_agent_that_fails_or_was_changed_ends_the_run_with_the_reason(tmp_path, capsys, data, reason):
    place = tmp_path / "mine.zip"
    place.write_bytes(data())
    command = ["leaderboard", "--agents", str(place), "--plants", "nominal", "--splits", "speeds", "--jobs", "1"]
    assert main(command) == 1
    error = capsys.readouterr().err
    assert reason in error
    assert error.count("\n") == 1


@pytest.mark.parametrize(("name", "reason"), [("elastic", "is that of another agent"), ("../mine", "must be letters")])
def test_a_name_that_cannot_be_a_row_is_refused(law, tmp_path, name, reason):
    place = tmp_path / "other.zip"
    place.write_bytes(changed(law.read_bytes(), manifest={"name": name}))
    with pytest.raises(FFGymError, match=reason):
        find_entrants(Registry(REGISTRY.known, REGISTRY.maker, (str(place),)))


def test_a_file_that_is_no_submission_is_one_line(tmp_path, capsys):
    for name, content in (("missing.zip", None), ("empty.zip", b"")):
        if content is not None:
            (tmp_path / name).write_bytes(content)
        assert main(["leaderboard", "--agents", str(tmp_path / name), "--plants", "nominal"]) == 1
        error = capsys.readouterr().err
        assert name in error
        assert error.count("\n") == 1
