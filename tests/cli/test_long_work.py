"""Work that would take hours is asked about on a terminal, and refused elsewhere, before it begins."""

import io

import numpy as np
import pytest

from ffgym.cli import long_work
from ffgym.cli.long_work import LongWork, rate, write_time
from ffgym.cli.main import main
from ffgym.cli.motion_options import Demo, Play, Simulate
from ffgym.cli.progress import progress_bar
from ffgym.core.effort import announce, watched
from ffgym.core.errors import FFGymError
from ffgym.paths.circles import circle_test, circle_test_duration
from tests.cli.errors import read_error


@pytest.fixture
def slow(monkeypatch):
    """A computer that simulates ten seconds of motion in a second, on whatever number of threads."""
    monkeypatch.setattr(long_work, "rate", lambda threads: 10.0)


class Terminal(io.StringIO):
    """What is typed on a terminal, or read from it."""

    def isatty(self):
        return True


@pytest.mark.parametrize(
    "command",
    [
        ("demo", "--speeds-mm-s", "0.01", "--no-diagnosis"),
        ("play", "--speed-mm-s", "0.001"),
        ("train", "bspline", "--speeds-mm-s", "0.001"),
        ("train", "stability", "--speeds-mm-s", "0.001"),
        ("improve", "--out", "folder", "--speeds-mm-s", "0.001"),
    ],
)
def test_a_slip_of_a_unit_is_refused_before_anything_is_planned_and_leaves_no_file(
    slow, command, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    assert main(command) == 1
    error = read_error(capsys)
    assert "of motion would take about" in error
    assert "Check units of speeds and times, or choose fewer motions; --yes begins it all the same." in error
    assert not list(tmp_path.iterdir())


def test_a_motion_of_a_file_is_refused_before_it_is_simulated(slow, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    part = '[[part]]\nkind = "sine"\nfrequency = 0.01\namplitude = 0.002\nduration = 20000.0\n'
    (tmp_path / "sine.toml").write_text(part)
    assert main(["simulate", "one_axis", "sine.toml"]) == 1  # two laws
    assert "11 h of motion would take about 67 min" in read_error(capsys)


def test_with_yes_nothing_is_refused(slow):
    with watched(LongWork(agreed=True)):
        announce(1e9, "plan all")
        announce(1e9, "run")


@pytest.mark.parametrize(("typed", "is_begun"), [("y\n", True), ("Yes\n", True), ("\n", False), ("no\n", False)])
def test_on_a_terminal_it_is_asked_once(slow, typed, is_begun, monkeypatch):
    asked = Terminal()
    monkeypatch.setattr("sys.stdin", Terminal(typed))
    monkeypatch.setattr("sys.stderr", asked)
    with watched(LongWork(agreed=False)):
        if is_begun:
            announce(36_001.0, "plan all")
            announce(36_001.0, "plan")  # does not ask again
        else:
            with pytest.raises(FFGymError, match="Not begun"):
                announce(36_001.0, "plan all")
    question = "10 h of motion would take about 60 min to simulate on this computer. Go on? [y/N] "
    assert asked.getvalue() == f"ffgym: {question}"


def test_motions_add_up_and_count_for_every_agent(slow):
    with watched(LongWork(agreed=False, passes=3)):
        for _ in range(3):
            announce(4000.0, "plan")
        with pytest.raises(FFGymError, match="13 h of motion"):
            announce(4000.0, "plan")


def test_a_simulation_says_how_long_it_takes_before_it_begins(slow, capsys):
    with watched(LongWork(agreed=False)), progress_bar("simulating", "s") as progress:
        progress(0.0, 1200.0)
        assert capsys.readouterr().err == "ffgym: 20 min of motion, about 2 min\n"
        progress(1.0, 1200.0)
    with watched(LongWork(agreed=False)), progress_bar("simulating", "s") as progress:
        progress(0.0, 60.0)
        with pytest.raises(FFGymError, match="28 h of motion"):
            announce(1e5, "run")
    assert not capsys.readouterr().err


def test_options_say_how_often_motions_are_run_and_what_is_drawn(slow):
    for options, motion in ((Demo(agents=("none", "elastic")), 18_001.0), (Simulate("one_axis", "sine"), 18_001.0)):
        with watched(long_work.watch_over(options)), pytest.raises(FFGymError, match="10 h of motion"):
            announce(motion, "plan all")
    with watched(long_work.watch_over(Play())):
        announce(5000.0, "plan")
        with pytest.raises(FFGymError, match="95 min of motion would take about 62 min"):
            announce(700.0, "plan")
    with watched(long_work.watch_over(Play(playback=1e-4))), pytest.raises(FFGymError, match="about 14 h to"):
        announce(20.0, "plan")  # many pictures of a short motion


def test_the_time_of_circles_is_known_before_their_path_is_made():
    for speed, radii in ((0.01, (0.001, 0.003)), (0.1, (0.005,))):
        path = circle_test(np.zeros(3), speed, radii=radii)
        assert circle_test_duration(speed, radii) == pytest.approx(path.t[-1], abs=0.004)


def test_the_estimate_is_near_what_a_simulation_takes(arm):
    from time import process_time

    from ffgym.simulation import Run, SimulatedRig
    from ffgym.studies import circle_references

    reference = circle_references(arm, ["p1"], [0.02], [0.003])["p1", 0.02]
    begun = process_time()
    SimulatedRig(arm=arm).run([Run(reference=reference)], n_threads=1)
    took = process_time() - begun
    assert 0.1 < (reference.duration / rate(1)) / took < 10  # other processes share this computer


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(12.34, "12 s"), (119.0, "2 min"), (4000.0, "67 min"), (7200.0, "2 h"), (3e5, "3.5 days"), (1e9, "11574 days")],
)
def test_times_are_told_in_a_unit_that_suits_them(seconds, words):
    assert write_time(seconds) == words
