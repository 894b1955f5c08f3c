"""The process of an agent: where it comes from, how it ends, and what an agent may count on in it."""

import subprocess
import sys

import numpy as np
import pytest

import ffgym
from ffgym.core.errors import FFGymError
from ffgym.leaderboard.submission import process as processes
from ffgym.leaderboard.submission import worker
from ffgym.leaderboard.submission.refusal import LONGEST, Refused
from tests.leaderboard.submission_samples import agent_file, process
from tests.processes import is_alive, waited

LAYOUT_SIZE = 9 * 6


def decide(content, steps=1, rows=1, **limits):
    """Actions of an agent on zeros."""
    with process(content, **limits) as agent:
        state, actions = None, []
        for _ in range(steps):
            action, state = agent.predict(np.zeros((rows, LAYOUT_SIZE)), state, np.zeros(rows, dtype=bool))
            actions.append(action)
    return np.array(actions)


def test_an_agent_finds_the_package_that_asks_and_not_another_installation():
    head = f"import ffgym\nif ffgym.__file__ != {ffgym.__file__!r}:\n    raise ValueError(ffgym.__file__)"
    assert decide(agent_file(head=head)).shape == (1, 1, 6)


def test_another_package_than_the_one_that_asks_is_refused():
    with pytest.raises(FFGymError, match="must be the one in /elsewhere/ffgym"):
        worker._check_package("/elsewhere/ffgym")


def test_an_agent_is_not_reached_through_its_folder_or_the_packages_of_a_user(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    lines = (
        "import sys",
        "if sys.path[0] == '' or not sys.flags.safe_path or not sys.flags.no_user_site:",
        "    raise ValueError('open')",
        f"if {str(tmp_path)!r} in sys.path:",
        "    raise ValueError('told')",
    )
    assert decide(agent_file(head="\n".join(lines))).shape == (1, 1, 6)


def test_sets_of_names_have_one_order_in_all_processes():
    body = "action = action * 0 + hash('friction') % 1000 / 1000"
    assert np.array_equal(decide(agent_file(body)), decide(agent_file(body)))


def test_classes_of_an_agent_may_be_dataclasses_with_written_types_and_be_pickled():
    head = (
        "import pickle\nfrom dataclasses import dataclass\n\n@dataclass\nclass Gain:\n    value: 'float' = 1.0\n\n"
        "pickle.loads(pickle.dumps(Gain()))"
    )
    content = b"from __future__ import annotations\n" + agent_file(head=head)
    assert decide(content).shape == (1, 1, 6)


def test_an_agent_that_uses_up_its_processor_time_is_refused_with_the_limit():
    with pytest.raises(Refused, match="it took more than 1 s of processor time"):
        decide(agent_file("while True:\n    pass"), cpu_seconds=1)


def test_an_agent_that_sleeps_is_refused_before_it_wastes_hours():
    with pytest.raises(Refused, match="must be late by at most") as caught:
        decide(agent_file("time.sleep(0.1)"), steps=100, late_s=0.5)
    assert caught.value.check == "time"


def test_setting_the_clock_does_not_make_an_agent_faster():
    head = "time.perf_counter_ns = lambda: 0\nimport sys\nfor each in list(sys.modules.values()):\n"
    head += "    if hasattr(each, '_CLOCK'):\n        each._CLOCK = time.perf_counter_ns"
    with process(agent_file("time.sleep(0.01)", head)) as agent:
        agent.predict(np.zeros((1, LAYOUT_SIZE)))
        assert agent.elapsed_ns > 5e6


def test_what_an_agent_started_ends_with_it(monkeypatch):
    def begin(own, log):
        code = "import subprocess, sys; print(subprocess.Popen(['sleep', '60']).pid, file=sys.stderr, flush=True)"
        with log.open("wb") as file:
            return subprocess.Popen(
                [sys.executable, "-c", code],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=file,
                start_new_session=True,
            )

    monkeypatch.setattr(processes, "launch", begin)
    agent = process(agent_file())
    child = int(waited(agent._log.read_text))
    agent._process.wait()
    assert is_alive(child)
    agent.close()
    assert waited(lambda: not is_alive(child))


def test_a_missing_folder_for_temporary_files_is_told_in_a_line(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "gone"))
    with pytest.raises(FFGymError, match="TMPDIR"):
        process(agent_file())


def test_a_full_disk_is_told_in_a_line_and_nothing_is_left(tmp_path, monkeypatch):
    def full(own, log):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr(processes, "launch", full)
    with pytest.raises(FFGymError, match="No space left"):
        process(agent_file())
    assert not list(tmp_path.iterdir())


def test_a_reason_is_one_short_line_whatever_an_agent_says():
    with pytest.raises(Refused) as caught:
        decide(agent_file("raise ValueError('a\\x1b[2J\\u202e' + 'x' * 5000)"))
    assert len(caught.value.reason) <= LONGEST
    assert caught.value.reason.isprintable()
    assert "a?[2J?x" in caught.value.reason
