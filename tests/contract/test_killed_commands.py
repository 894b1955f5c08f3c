"""Each command that writes, killed at any point and begun again, writes the same; two at once do not spoil a place."""

import random
import re
import shutil
import signal

import pytest

from ffgym.core.provenance import is_installed
from tests.contract.killing import process_of_commands
from tests.contract.writing_commands import EXAMPLES, REAL_TIME, make_stock, make_whole_stock, writing_commands

KILLS = 20
"""Kills of each command by the slow test."""
MINUTE = rb"\d{4}-\d\d-\d\d \d\d:\d\d UTC"
"""Time that a page says it was written, which differs."""
TENSORBOARD = "tensorboard"
"""Folder of a training whose files have times in their names."""
FEW = 2
"""Kills of the quick ones by the usual tests."""
CHEAP = ["robot fill", "plan", "export table", "record"]
"""Commands of the usual tests, of each kind of place: a file that is changed, files, a new folder, a filled one."""


@pytest.fixture(scope="module")
def few(tmp_path_factory):
    """The process of the commands of the usual tests."""
    with process_of_commands(tmp_path_factory.mktemp("few"), f"{make_stock.__module__}:{make_stock.__name__}") as made:
        yield made


@pytest.fixture(scope="module")
def every(tmp_path_factory):
    """The process of all commands."""
    name = f"{make_whole_stock.__module__}:{make_whole_stock.__name__}"
    with process_of_commands(tmp_path_factory.mktemp("every"), name) as made:
        yield made


def begin(killing, name):
    """Make the working directory of an example anew."""
    shutil.rmtree(killing.folder)
    killing.folder.mkdir()
    for file in EXAMPLES[name].given:
        shutil.copy(killing.place / "stock" / file, killing.folder)


def run(killing, name, *more, **how):
    """Run an example."""
    return killing.run(*name.split(), *EXAMPLES[name].arguments.split(), *more, **how)


def written(killing, name):
    """Bytes of all files of an example by their names, without what may differ; no remains are among them."""
    differs = EXAMPLES[name].differs
    assert not remains(killing)
    files = {
        path.relative_to(killing.folder).as_posix(): path.read_bytes()
        for path in sorted(killing.folder.rglob("*"))
        if path.is_file() and path.parent.name != TENSORBOARD
    }
    return {file: differs(re.sub(MINUTE, b"", data)) for file, data in files.items()}


def remains(killing):
    """List temporary files and folders, and claims."""
    return [path for folder in ("run", "tmp") for path in (killing.place / folder).rglob(".ffgym-*")]


def run_whole(killing, name):
    """Run an example without harm; returns its answer, and what it wrote."""
    begin(killing, name)
    whole = run(killing, name)
    assert whole["code"] == 0, whole["err"]
    files = written(killing, name)
    assert files
    return whole, files


def spread(points, count):
    """List this many points from the first to the last."""
    return [1 + round(k * (points - 1) / max(count - 1, 1)) for k in range(count)]


def kill_and_begin_again(killing, name, kills, seed=0):
    """Kill a command at points spread over its writing and at random times, begin it again, and compare bytes."""
    whole, wanted = run_whole(killing, name)
    rng, at_times = random.Random(seed), kills // 4
    times = [1e-3 + whole["seconds"] * rng.uniform(0, 1) for _ in range(at_times)]
    for how in [
        *({"at": point} for point in spread(whole["points"], kills - at_times)),
        *({"after": t} for t in times),
    ]:
        begin(killing, name)
        killed = run(killing, name, **how)
        assert killed["code"] in (-signal.SIGKILL, -signal.SIGALRM) or "after" in how, killed["err"]
        check_again(killing, name, wanted)


def end_and_begin_again(killing, name, by, count):
    """End a command by a signal at some points, and begin it again."""
    whole, wanted = run_whole(killing, name)
    for point in spread(whole["points"], count):
        begin(killing, name)
        ended = run(killing, name, at=point, by=by)
        word = "interrupted" if by == signal.SIGINT else f"ended by {by.name}"
        line = f"ffgym: {word}; files that were finished before stay, none is half-written\n"
        assert (ended["code"], ended["err"]) == (128 + by, line)
        assert not remains(killing)
        check_again(killing, name, wanted)


def check_again(killing, name, wanted):
    """Begin a command again, and compare what it writes; a folder that it made before is whole, and removed."""
    if makes := EXAMPLES[name].makes:
        made = killing.folder / makes
        if made.exists():
            begun = {path.relative_to(killing.folder).as_posix() for path in made.rglob("*") if path.is_file()}
            assert begun == {file for file in wanted if file.startswith(f"{makes}/")}
            assert run(killing, name)["code"] == 1  # nothing is overwritten
            shutil.rmtree(made)
    again = run(killing, name)
    assert again["code"] == 0, again["err"]
    assert written(killing, name) == wanted


def run_two_at_once(killing, name):
    """Begin a command, and once more while it is in the middle of its writing."""
    whole, wanted = run_whole(killing, name)
    begin(killing, name)
    first = run(killing, name, at=whole["points"] // 2, by=signal.SIGSTOP)
    assert first["code"] == -signal.SIGSTOP
    try:
        second = run(killing, name)
    finally:
        first = killing.go_on(first["pid"])
    assert second["code"] == 1
    (line,) = second["err"].splitlines()
    assert f"process {first['pid']} (ffgym {name}" in line
    assert line.endswith("is writing there. Wait for it, end it, or choose another place.")
    assert first["code"] == 0
    assert written(killing, name) == wanted


def skip_without(name):
    """Skip where a package or program is missing that an example needs."""
    for needed in EXAMPLES[name].needs:
        if not is_installed(needed) and shutil.which(needed) is None:
            pytest.skip(f"{needed} is not installed")


def test_every_command_that_writes_has_an_example():
    assert {*writing_commands()} - REAL_TIME == {*EXAMPLES}


@pytest.mark.parametrize("name", CHEAP)
def test_a_command_that_is_killed_and_begun_again_writes_the_same(few, name):
    kill_and_begin_again(few, name, FEW)


@pytest.mark.parametrize("name", CHEAP)
@pytest.mark.parametrize("by", [signal.SIGTERM, signal.SIGINT])
def test_a_command_that_a_signal_ends_says_so_in_a_line_and_cleans_up(few, name, by):
    end_and_begin_again(few, name, by, FEW)


@pytest.mark.parametrize("name", CHEAP)
def test_of_two_runs_at_once_one_writes_and_the_other_says_who(few, name):
    run_two_at_once(few, name)


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_no_two_runs_of_a_command_write_at_once(every, name):
    skip_without(name)
    run_two_at_once(every, name)


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_a_signal_ends_a_command_at_any_point(every, name):
    skip_without(name)
    end_and_begin_again(every, name, signal.SIGTERM, KILLS // 4)
    end_and_begin_again(every, name, signal.SIGINT, KILLS // 4)


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_a_command_that_is_killed_at_any_point_writes_the_same_when_begun_again(every, name):
    skip_without(name)
    kill_and_begin_again(every, name, KILLS)
