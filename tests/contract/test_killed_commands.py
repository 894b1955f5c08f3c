"""Each command that writes, killed at any point and begun again, writes the same; two at once do not spoil a place."""

import random
import shutil
import signal

import pytest

from tests.contract.runs import CHEAP, begin, remains, run, skip_without, written
from tests.contract.writing_commands import EXAMPLES, REAL_TIME, writing_commands

KILLS = 20
"""Kills of each command by the slow test."""
FEW = 2
"""Kills of the quick ones by the usual tests."""


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


def test_every_command_that_writes_has_an_example():
    assert {*writing_commands()} - REAL_TIME == {*EXAMPLES}


@pytest.mark.parametrize("name", CHEAP)
def test_a_command_that_is_killed_and_begun_again_writes_the_same(few, name):
    kill_and_begin_again(few, name, FEW)


@pytest.mark.parametrize("name", CHEAP)
@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
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
