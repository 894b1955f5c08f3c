"""The process of an agent: where it comes from, how it ends, and what an agent may count on in it."""

import os
import socket
import subprocess
import sys

import numpy as np
import pytest

import ffgym
from ffgym.core.errors import FFGymError
from ffgym.leaderboard.submission import process as processes
from ffgym.leaderboard.submission.manifest import LONGEST, Refused
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
    head = "time.perf_counter = time.perf_counter_ns = lambda: 0\nimport sys\nfor each in list(sys.modules.values()):\n"
    head += "    if hasattr(each, '_CLOCK'):\n        each._CLOCK = time.perf_counter_ns"
    with process(agent_file("time.sleep(0.01)", head)) as agent:
        agent.predict(np.zeros((1, LAYOUT_SIZE)))
        assert agent.elapsed_us > 5e3


def test_what_an_agent_started_ends_with_it(monkeypatch):
    monkeypatch.setattr(processes, "_exposed", lambda: "not in this test")  # its processes have other numbers there
    head = "import subprocess\nchild = subprocess.Popen(['sleep', '60']).pid"
    with process(agent_file("action = action * 0 + child / 2**22", head)) as agent:
        action, _ = agent.predict(np.zeros((1, LAYOUT_SIZE)))
        child = round(float(action[0, 0]) * 2**22)
        assert is_alive(child)
    assert waited(lambda: not is_alive(child))


def test_random_numbers_begin_at_the_seed():
    pytest.importorskip("torch")
    head = "import random, torch\ndrawn = [random.random(), np.random.random(), float(torch.rand(1))] * 2"
    first, second = (decide(agent_file("action = action * 0 + np.array([drawn])", head)) for _ in range(2))
    assert np.array_equal(first, second)
    assert len(np.unique(first)) == 3


isolated = pytest.mark.skipif(processes._exposed() is not None, reason="no bubblewrap that works here")


@isolated
@pytest.mark.parametrize(
    "denied",
    [
        "import ffgym.workcell.cell",
        "open(SECRET)",
        "os.kill(PARENT, 0)",
        "open(os.__file__ + '.written', 'w')",
        "socket.create_connection(('127.0.0.1', PORT), timeout=2)",
    ],
)
def test_an_isolated_agent_reaches_neither_truth_nor_files_nor_processes_nor_network(tmp_path, denied):
    secret = tmp_path / "secret.txt"
    secret.write_text("seen")
    with socket.create_server(("127.0.0.1", 0)) as server:
        names = f"SECRET, PARENT, PORT = {str(secret)!r}, {os.getpid()}, {server.getsockname()[1]}\n"
        head = f"import os, socket\n{names}try:\n    {denied}\nexcept (ImportError, OSError):\n    pass\nelse:\n"
        assert decide(agent_file(head=head + "    raise ValueError('reached')")).shape == (1, 1, 6)


@isolated
def test_an_isolated_agent_may_write_in_its_own_folder():
    assert decide(agent_file(head="open('notes.txt', 'w').write('mine')")).shape == (1, 1, 6)


def test_one_sentence_says_where_nothing_isolates(monkeypatch):
    monkeypatch.setattr(processes, "_exposed", lambda: "no program bwrap")
    monkeypatch.delenv(processes.DECLARED, raising=False)
    assert "Nothing isolates agents here (no program bwrap)" in processes.isolation_note()
    monkeypatch.setenv(processes.DECLARED, "container")
    assert processes.isolation_note() is None


def test_bubblewrap_that_cannot_start_is_told_with_its_reason(tmp_path, monkeypatch):
    program = tmp_path / "bwrap"
    program.write_text("#!/bin/sh\necho 'bwrap: No permissions to create a new namespace' >&2\nexit 1\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    assert "No permissions to create a new namespace" in processes._exposed.__wrapped__()


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


def outcome(content, steps=2, **limits):
    """Why an agent is refused."""

    def decide():
        with process(content, **limits) as agent:
            state = None
            for _ in range(steps):
                _, state = agent.predict(np.zeros((3, LAYOUT_SIZE)), state, np.zeros(3, dtype=bool))

    with pytest.raises(Refused) as caught:
        decide()
    assert caught.value.check == "agent"
    return caught.value.reason


def test_an_honest_agent_answers_for_all_robots_and_remembers():
    with process(agent_file("action = action + 0.01 * count")) as agent:
        assert (agent.preview, agent.action_scale) == (1, 10.0)
        first, state = agent.predict(np.zeros((3, LAYOUT_SIZE)))
        second, _ = agent.predict(np.zeros((3, LAYOUT_SIZE)), state)
    assert first.shape == (3, 6)
    assert np.allclose(second - first, 0.01)


def test_an_agent_may_ask_on_which_platform_it_is():
    with process(agent_file(head="import platform\nplatform.platform()")) as agent:
        assert agent.preview == 1


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ("action = action * np.nan", "predict returned NaN"),
        ("action = action[:, :5]", "predict returned actions of shape (3, 5), must be (3, 6)"),
        ("return action", "predict must return actions and state"),
        ("return np.array([['a'] * 6] * 3), None", "must be numbers"),
        ("1 / 0", "it raised ZeroDivisionError: division by zero (agent.py, line 16)"),
        ("self.layout.read(observation, 'nothing')", "(agent.py, line 16)"),
        ("import os\nos._exit(7)", "its process ended by itself with code 7"),
        ("raise SystemExit", "it raised SystemExit"),
    ],
)
def test_an_agent_that_fails_is_refused_with_how(body, reason):
    assert reason in outcome(agent_file(body))


def test_an_agent_that_never_answers_is_ended():
    assert "it took more than 0.3 s for one decision, and was ended" in outcome(
        agent_file("while True:\n    pass"), decision_s=0.3
    )


def test_an_agent_that_never_answers_ends_with_who_asked_it():
    code = (
        "import numpy as np\n"
        "from tests.leaderboard.submission_samples import agent_file, process\n"
        "with process(agent_file('while True:\\n    pass')) as agent:\n"
        "    print(agent._process.pid, flush=True)\n"
        f"    agent.predict(np.zeros((3, {LAYOUT_SIZE})), None, np.zeros(3, dtype=bool))\n"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as asks:
        agent = int(asks.stdout.readline())
        assert is_alive(agent)
        asks.kill()
    assert waited(lambda: not is_alive(agent))


def test_an_agent_that_is_never_made_is_ended():
    assert "it took more than 2 s to be made" in outcome(agent_file(head="time.sleep(600)"), start_s=2.0)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"PREVIEW = 1", "does not define ACTION_SCALE, make_agent"),
        (b"PREVIEW = (", "It is no Python file"),
        (agent_file(head="PREVIEW = 'x'"), "PREVIEW must be a number"),
        (agent_file(head="ACTION_SCALE = float('inf')"), "ACTION_SCALE must be finite"),
        (b"PREVIEW, ACTION_SCALE = 1, 1.0\ndef make_agent(robot, layout): return 5", "int, which has no predict"),
    ],
)
def test_a_file_that_makes_no_agent_is_refused(content, reason):
    assert reason in outcome(content)


def test_what_an_agent_prints_is_no_answer_and_its_environment_is_its_own(monkeypatch):
    monkeypatch.setenv("FFGYM_SECRET", "1")
    head = "import os\nif any(name.startswith('FFGYM') for name in os.environ):\n    raise ValueError('seen')"
    with process(agent_file("print('A' * 100, flush=True)", head)) as agent:
        action, _ = agent.predict(np.zeros((3, LAYOUT_SIZE)))
    assert action.shape == (3, 6)
