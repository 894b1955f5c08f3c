import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from types import MappingProxyType

import pytest

from ffgym.agents.entrants import ENTRANTS, REGISTRY
from ffgym.control import NoCompensation
from ffgym.core.errors import FFGymError
from ffgym.core.executors import Executor
from ffgym.core.provenance import is_installed
from ffgym.leaderboard.board import Board, sum_durations
from ffgym.leaderboard.entrants import Entrant, ReadyAgent, Registry, one_by_one
from ffgym.leaderboard.evaluation import jobs
from ffgym.leaderboard.results import decode_row, encode_row, read_row
from ffgym.leaderboard.tasks import make_references
from tests.processes import held_elsewhere

HERE = Executor(jobs=1)


def entrants(*names):
    return [ENTRANTS[name] for name in names]


@pytest.fixture
def counted(monkeypatch):
    """Jobs that were run."""
    done = []
    run_job = jobs.run_job

    def counting(job):
        done.append(job)
        return run_job(job)

    monkeypatch.setattr(jobs, "run_job", counting)
    return done


def run(board, names=("none", "lugre_static"), plants=("nominal",), splits=("speeds",)):
    return board.run(entrants(*names), plants, splits, 1, HERE)


def test_the_track_of_a_row_is_what_its_agent_declares_also_in_older_files(tmp_path):
    text = encode_row(ENTRANTS["servo_gains"].row())
    older = "\n".join(line for line in text.splitlines() if '"feedback"' not in line)
    (tmp_path / "servo_gains.json").write_text(older)
    [row], _ = Board(registry=REGISTRY, folder=tmp_path).current()
    assert row.control == "with feedback"


def test_what_is_in_the_folder_is_not_run_again(tmp_path, counted):
    assert run(Board(registry=REGISTRY, folder=tmp_path / "board")) > 0
    files = {path.name: path.read_bytes() for path in (tmp_path / "board").iterdir()}
    assert sorted(files) == ["lugre_static.json", "none.json"]
    assert run(Board(registry=REGISTRY, folder=tmp_path / "board")) == 0
    assert len(counted) == 1
    assert {path.name: path.read_bytes() for path in (tmp_path / "board").iterdir()} == files


def test_only_what_is_missing_is_run(tmp_path, counted):
    run(Board(registry=REGISTRY, folder=tmp_path), ["none"])
    board = Board(registry=REGISTRY, folder=tmp_path)
    run(board, plants=["nominal", "draw:0"])
    assert sorted((job.plant, job.agents) for job in counted[1:]) == [
        ("draw:0", (("none", 0), ("lugre_static", 0))),
        ("nominal", (("lugre_static", 0),)),
    ]
    assert [outcome.plant for outcome in board.rows["none"].outcomes] == ["nominal", "draw:0"]


def test_circles_of_another_run_stay(tmp_path):
    run(Board(registry=REGISTRY, folder=tmp_path), ["none"], splits=["speeds"])
    run(Board(registry=REGISTRY, folder=tmp_path), ["none"], splits=["radii"])
    [outcome] = read_row(tmp_path / "none.json").outcomes
    assert {cell.split for cell in outcome.cells} == {"speeds", "radii"}


@pytest.mark.parametrize("change", [{"fingerprint": "0" * 16}, {"artefact": "0" * 64}])
def test_results_of_other_physics_or_another_artefact_are_made_again(tmp_path, counted, change):
    run(Board(registry=REGISTRY, folder=tmp_path), ["none"])
    row, first = read_row(tmp_path / "none.json"), timeless(tmp_path / "none.json")
    (tmp_path / "none.json").write_text(
        encode_row(replace(row, outcomes=tuple(replace(o, **change) for o in row.outcomes)))
    )
    run(Board(registry=REGISTRY, folder=tmp_path), ["none"])
    assert len(counted) == 2
    assert timeless(tmp_path / "none.json") == first


def test_circles_of_other_physics_do_not_stay_beside_new_ones(tmp_path):
    run(Board(registry=REGISTRY, folder=tmp_path), ["none"], splits=["radii"])
    row = read_row(tmp_path / "none.json")
    others = tuple(replace(outcome, fingerprint="0" * 16) for outcome in row.outcomes)
    (tmp_path / "none.json").write_text(encode_row(replace(row, outcomes=others)))
    run(Board(registry=REGISTRY, folder=tmp_path), ["none"], splits=["speeds"])
    [outcome] = read_row(tmp_path / "none.json").outcomes
    assert {cell.split for cell in outcome.cells} == {"speeds"}


def test_what_is_of_another_physics_or_artefact_is_told_and_not_compared(tmp_path):
    board = Board(registry=REGISTRY, folder=tmp_path)
    run(board, ["none", "lugre_static", "elastic"])
    assert [(row.name, len(row.outcomes)) for row in board.current()[0]] == [
        ("none", 1), ("lugre_static", 1), ("elastic", 1),
    ]  # fmt: skip
    for name, change in (("lugre_static", {"fingerprint": "0" * 16}), ("elastic", {"artefact": "0" * 64})):
        row = board.rows[name]
        others = tuple(replace(outcome, **change) for outcome in row.outcomes)
        (tmp_path / f"{name}.json").write_text(encode_row(replace(row, outcomes=others)))
    mine = replace(board.rows["elastic"], name="mine")
    (tmp_path / "mine.json").write_text(encode_row(mine))
    rows, told = Board(registry=REGISTRY, folder=tmp_path).current()
    assert [(row.name, len(row.outcomes)) for row in rows] == [("none", 1), ("lugre_static", 0), ("elastic", 0)]
    assert told == [
        "mine is no agent of this leaderboard",
        "lugre_static has 1 of 1 outcomes of other physics or artefacts",
        "elastic has 1 of 1 outcomes of other physics or artefacts",
    ]


@pytest.mark.slow
def test_the_order_of_runs_is_not_seen_in_the_file(tmp_path):
    for folder, order in (("one", ["radii", "speeds"]), ("other", ["speeds", "radii"])):
        for split in order:
            run(Board(registry=REGISTRY, folder=tmp_path / folder), ["none"], splits=[split])
    run(Board(registry=REGISTRY, folder=tmp_path / "once"), ["none"], splits=["radii", "speeds"])
    assert len({timeless(tmp_path / folder / "none.json") for folder in ("one", "other", "once")}) == 1


def _practised(plant, seed, tasks):
    return ReadyAgent(
        law=NoCompensation(), robot_seconds=sum(r.duration for r in make_references(plant.rig.arm, tasks))
    )


PRACTISES = MappingProxyType(
    {"none": Entrant(name="none", title="-", track="-", about="-", slow=True, ready=one_by_one(_practised))}
)
"""Somebody who goes through every task once beforehand."""


def test_who_practises_every_task_moved_the_machine_for_all_of_them(tmp_path):
    for orders in (["radii", "speeds"], ["speeds", "radii"], ["speeds", "radii", "radii"]):
        board = Board(registry=Registry(f"{__name__}:PRACTISES"))
        for split in orders:
            board.run(list(PRACTISES.values()), ["nominal"], [split], 1, HERE)
        [outcome] = board.rows["none"].outcomes
        assert outcome.robot_seconds == pytest.approx(sum_durations(["nominal"], ["radii", "speeds"]), rel=1e-5)


def test_results_of_other_versions_stay_and_are_told(tmp_path):
    board = Board(registry=REGISTRY, folder=tmp_path)
    run(board, ["none"], splits=["radii"])
    row = board.rows["none"]
    old = tuple(replace(outcome, versions="ffgym 0.0") for outcome in row.outcomes)
    (tmp_path / "none.json").write_text(encode_row(replace(row, outcomes=old)))
    run(Board(registry=REGISTRY, folder=tmp_path), ["none"], splits=["speeds"])
    [outcome] = read_row(tmp_path / "none.json").outcomes
    assert outcome.versions == f"ffgym 0.0; {row.outcomes[0].versions}"
    assert {cell.split for cell in outcome.cells} == {"speeds", "radii"}


def test_a_file_holds_what_was_found(tmp_path):
    board = Board(registry=REGISTRY, folder=tmp_path)
    run(board, ["none"])
    assert read_row(tmp_path / "none.json") == board.rows["none"]


def test_any_number_of_processes_gives_the_same_rows(tmp_path):
    for n in (1, 2):
        board = Board(registry=REGISTRY, folder=tmp_path / str(n))
        board.run(entrants("none", "lugre_static"), ["nominal", "draw:0"], ["speeds"], 1, Executor(jobs=n))
    for name in ("none.json", "lugre_static.json"):
        assert timeless(tmp_path / "1" / name) == timeless(tmp_path / "2" / name)


def timeless(path):
    """A row's file without how long decisions took, which no two runs have in common."""
    row = read_row(path)
    return encode_row(replace(row, outcomes=tuple(replace(o, inference_us=None) for o in row.outcomes)))


@pytest.mark.slow
@pytest.mark.skipif(not is_installed("ray"), reason="Ray is not installed")
@pytest.mark.filterwarnings("ignore")
def test_a_ray_cluster_gives_the_same_rows(tmp_path):
    for executor in (Executor(jobs=1), Executor(kind="ray", jobs=2)):
        board = Board(registry=REGISTRY, folder=tmp_path / executor.kind)
        board.run(entrants("none", "elastic"), ["nominal", "draw:0"], ["speeds"], 1, executor)
    for name in ("none.json", "elastic.json"):
        assert timeless(tmp_path / "local" / name) == timeless(tmp_path / "ray" / name)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("{", "is not valid JSON"),
        ('{"format": 7}', "has format 7, this version of ffgym reads 1"),
        ('{"format": 1, "name": "none"}', "is no result of the leaderboard"),
        ("[]", "has format None"),
    ],
)
def test_a_damaged_file_is_told_and_kept(tmp_path, text, reason):
    place = tmp_path / "none.json"
    place.write_text(text)
    with pytest.raises(FFGymError, match=reason):
        Board(registry=REGISTRY, folder=tmp_path)
    assert place.read_text() == text


def twice(entries):
    return [*entries, entries[0]]


def in_cell(**change):
    return lambda tree: tree["outcomes"][0]["cells"][0].update(change)


def in_outcome(**change):
    return lambda tree: tree["outcomes"][0].update(change)


@pytest.mark.parametrize(
    ("damage", "reason"),
    [
        (lambda tree: tree.update(outcomes=twice(tree["outcomes"])), "the outcome .0, 'nominal'. stands there 2 times"),
        (lambda tree: tree["outcomes"][0].update(cells=twice(tree["outcomes"][0]["cells"])), "the circle .* 2 times"),
        (lambda tree: tree.update(learning_curve=[["a", "b"]]), r"row.learning_curve\[0\]\[0\] = 'a' must be a number"),
        (lambda tree: tree.update(learning_curve=[[1, 2, 3]]), "must be a list of 2"),
        (lambda tree: tree.update(title=5), "row.title = 5 must be text"),
        (lambda tree: tree.pop("title"), "row lacks title"),
        (lambda tree: tree.update(more=1), "has unknown entries more"),
        (in_cell(rms_mm="0.1"), "rms_mm = '0.1' must be a number"),
        (in_cell(max_mm=float("nan")), "max_mm = nan must be a finite number, or null"),
        (in_cell(radius_mm=None), "radius_mm must be finite"),
        (in_cell(motor_rms_rad=["x"]), "must be a number"),
        (in_cell(split="moon"), "Unknown split 'moon'"),
        (in_outcome(plant="draw:x"), "plant = 'draw:x' must be nominal"),
        (in_outcome(plant="draw:00"), "plant = 'draw:00' must be nominal"),
        (in_outcome(plant=7), "plant = 7 must be text"),
        (in_outcome(seed="0"), "seed = '0' must be a whole number"),
        (in_outcome(robot_seconds=None), "robot_seconds must be finite"),
        (in_outcome(inference_us="x"), "inference_us = 'x' must be a number"),
    ],
)
def test_what_is_no_result_is_one_clear_error(good, damage, reason):
    tree = json.loads(good)
    damage(tree)
    with pytest.raises(FFGymError, match=reason) as found:
        decode_row(json.dumps(tree), "none.json")
    assert str(found.value).startswith("none.json: ")


@pytest.fixture(scope="module")
def good():
    """Text of a row's file."""
    board = Board(registry=REGISTRY)
    run(board, ["none"])
    return encode_row(board.rows["none"])


def test_a_file_of_another_name_is_refused(tmp_path):
    run(Board(registry=REGISTRY, folder=tmp_path), ["none"])
    (tmp_path / "none.json").rename(tmp_path / "best.json")
    with pytest.raises(FFGymError, match="holds the row 'none'; rename it"):
        Board(registry=REGISTRY, folder=tmp_path)


def test_a_folder_that_is_a_file_is_refused(tmp_path):
    (tmp_path / "board").touch()
    with pytest.raises(FFGymError, match="is a file, must be a folder"):
        Board(registry=REGISTRY, folder=tmp_path / "board")


def _nothing(plant, seed, tasks):
    return ReadyAgent(law=NoCompensation()) if plant.name == "nominal" else None


SHY = MappingProxyType({"none": Entrant(name="none", title="-", track="causal", about="-", ready=one_by_one(_nothing))})
"""Somebody who has nothing for drawn plants."""


def test_who_has_nothing_for_a_plant_has_no_outcome_there():
    board = Board(registry=Registry(f"{__name__}:SHY"))
    seconds = board.run(list(SHY.values()), ["nominal", "draw:0"], ["speeds"], 1, HERE)
    assert seconds == sum_durations(["nominal"], ["speeds"])
    assert [outcome.plant for outcome in board.rows["none"].outcomes] == ["nominal"]


def test_a_folder_that_another_process_fills_is_refused_and_left_as_it_is(tmp_path, counted):
    with held_elsewhere(tmp_path), pytest.raises(FFGymError, match=r"process \d+ .* is writing there"):
        run(Board(registry=REGISTRY, folder=tmp_path))
    assert (counted, list(tmp_path.iterdir())) == ([], [])


def test_what_another_process_wrote_meanwhile_is_not_run_again(tmp_path, counted):
    early = Board(registry=REGISTRY, folder=tmp_path)
    run(Board(registry=REGISTRY, folder=tmp_path), names=("none",))
    run(early)
    assert [dict(job.agents).keys() for job in counted] == [{"none"}, {"lugre_static"}]


@pytest.mark.slow
def test_killed_in_the_middle_it_goes_on_to_the_same_files(tmp_path):
    plants = [f"draw:{k}" for k in range(20)]
    command = [sys.executable, "-m", "ffgym", "leaderboard", "--agents", "lugre_static", "--plants", *plants]
    command += ["--splits", "speeds", "--jobs", "1", "--out"]
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    subprocess.run([*command, str(whole)], check=True, capture_output=True)
    process = subprocess.Popen([*command, str(broken)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while not list(broken.glob("*.json")):
        assert process.poll() is None
        time.sleep(0.01)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    before = read_row(broken / "none.json")
    assert 0 < len(before.outcomes) < len(plants)
    subprocess.run([*command, str(broken)], check=True, capture_output=True)
    for name in ("none.json", "lugre_static.json"):
        assert timeless(broken / name) == timeless(whole / name)
    assert not [path for path in broken.iterdir() if path.suffix != ".json"]
