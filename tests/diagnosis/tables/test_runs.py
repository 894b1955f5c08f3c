"""A diagnosis from a table has one result: killed and begun again, on one or several cores, or on Ray."""

import json
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from importlib import resources

import pytest

from ffgym.core.errors import FFGymError
from ffgym.core.executors import Executor
from ffgym.core.provenance import is_installed
from ffgym.diagnosis.tables.document import table_document
from ffgym.diagnosis.tables.fitting import FitTask, fit_structure
from ffgym.diagnosis.tables.procedure import diagnose_table
from ffgym.diagnosis.tables.table_file import write_table
from tests.diagnosis.tables.small_table import DT, FAST, SLOW, small_table
from tests.processes import waited

STAGES = ("search", f"without {SLOW}", f"without {FAST}")


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    return small_table(tmp_path_factory.mktemp("motions"))


def task(table, folder):
    return FitTask(table=table, name="numbers", folder=folder, steps=2, judge_dt=DT)


@pytest.fixture(scope="module")
def whole(table, tmp_path_factory):
    """State file of a fit that was left alone."""
    alone = task(table, tmp_path_factory.mktemp("whole"))
    fit_structure(alone)
    return alone.file.read_bytes()


def title(stage):
    return "numbers" if stage == "search" else f"numbers {stage}"


def fit_until(table, folder, words):
    """Fit until a text is told that begins with words, and be killed then."""

    def tell(text):
        if text.startswith(words):
            os.kill(os.getpid(), signal.SIGKILL)

    fit_structure(task(table, folder), tell)


@pytest.mark.parametrize(
    ("words", "begun"),
    [
        *(pytest.param(f"{title(STAGES[k])}: step 1", STAGES[: k + 1], marks=pytest.mark.slow) for k in (0, 1, 2)),
        ("numbers: all rows", STAGES),
    ],
)
def test_a_fit_that_is_killed_goes_on_with_the_same_bits(table, whole, tmp_path, words, begun):
    again = task(table, tmp_path)
    process = multiprocessing.get_context("spawn").Process(target=fit_until, args=(table, tmp_path, words))
    process.start()
    process.join()
    assert process.exitcode == -signal.SIGKILL
    state, told = json.loads(again.file.read_text()), []
    fit_structure(again, told.append)
    for stage in begun:  # each goes on at its last step
        assert state[stage]["steps"] >= 1
        first = next(text for text in told if text.startswith(f"{title(stage)}:"))
        assert first.startswith(f"{title(stage)}: step {state[stage]['steps']},")
    assert again.file.read_bytes() == whole


@pytest.mark.parametrize(("file", "old", "new"), [(SLOW, "0.7", "0.6"), ("arm.toml", "500000.0", "400000.0")])
def test_a_state_of_files_that_changed_is_refused(tmp_path, file, old, new):
    with resources.as_file(resources.files("ffgym.robot") / "data" / "two_link.toml") as built_in:
        shutil.copyfile(built_in, tmp_path / "arm.toml")
    table = replace(small_table(tmp_path), robot=str(tmp_path / "arm.toml"))
    one = FitTask(table=table, name="description", folder=tmp_path, steps=1, judge_dt=DT)
    fit_structure(one)
    text = (tmp_path / file).read_text()
    assert old in text
    (tmp_path / file).write_text(text.replace(old, new))
    with pytest.raises(FFGymError, match="is of another table, robot, motion, structure"):
        fit_structure(one)


def test_a_robot_without_a_tool_is_refused(table):
    with pytest.raises(FFGymError, match="'one_axis' of the table 'small' has no tool"):
        fit_structure(task(replace(table, robot="one_axis"), table.folder))


def diagnosed(table, folder, executor):
    found = diagnose_table(
        table,
        structures=("description", "numbers"),
        pairs=False,
        folder=folder,
        executor=executor,
        steps=2,
        judge_dt=DT,
        sessions=(),
    )
    return table_document(found)


@pytest.fixture(scope="module")
def document(table):
    """Result of one process."""
    return diagnosed(table, None, Executor(jobs=1))


def test_several_processes_give_the_same_document(table, document):
    assert diagnosed(table, None, Executor(jobs=2)) == document


@pytest.mark.slow
@pytest.mark.skipif(not is_installed("ray"), reason="Ray is not installed")
@pytest.mark.filterwarnings("ignore")
def test_a_ray_cluster_gives_the_same_document(table, document):
    assert diagnosed(table, None, Executor(kind="ray", jobs=2)) == document


@pytest.mark.slow
def test_a_command_that_is_killed_frees_its_folder_and_goes_on(table, tmp_path):
    write_table(tmp_path / "table.toml", table)
    for file in (SLOW, FAST):
        (tmp_path / file).write_text((table.folder / file).read_text())
    command = [sys.executable, "-m", "ffgym", "diagnose", "--table", str(tmp_path / "table.toml"), "--no-pairs"]
    command += ["--structures", "description", "numbers", "--steps", "2", "--jobs", "2", "--out"]
    state = tmp_path / "killed" / "structures" / "numbers.json"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen([*command, str(tmp_path / "killed")], **quiet)
    assert waited(state.exists, limit=60)
    process.kill()
    process.wait()
    assert "result" not in json.loads(state.read_text())
    for folder in ("killed", "whole"):
        subprocess.run([*command, str(tmp_path / folder)], check=True, **quiet)
    one, other = (json.loads((tmp_path / name / "table_diagnosis.json").read_text()) for name in ("killed", "whole"))
    assert one["structures"] == other["structures"]
    assert one["verdict"] == other["verdict"]
