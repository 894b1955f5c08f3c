"""The process of an agent: where it comes from, how it ends, and what an agent may count on in it."""

import os
import socket
import subprocess
import sys
from pathlib import Path

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


SEARCH = """
import ctypes
import os
import socket
import subprocess
import sys

libc = ctypes.CDLL(None, use_errno=True)


def libc_open(path):
    if libc.open(path.encode(), os.O_RDONLY) < 0:
        raise OSError(path)


def arrow_open(path):
    import pyarrow

    pyarrow.OSFile(path).read()


def started(*command):
    if subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode:
        raise OSError(command)


def uncover():
    if libc.umount2(TRUTH.encode(), 2):
        raise OSError(TRUTH)


def connect(kind, place):
    with socket.socket(kind) as client:
        client.settimeout(2)
        client.connect(place)


def written():
    if not os.access(os.__file__, os.W_OK):
        raise OSError(os.__file__)


def listed():
    if not any(os.path.exists(os.path.join(place, "ffgym/workcell/data/thesis.toml")) for place in sys.path):
        raise OSError("nothing")


SHELL = f"umount {TRUTH}; cat {TRUTH}/data/*"
TRIED = {
    "truth, by import": lambda: __import__("ffgym.workcell.cell"),
    "truth, on the path of Python": listed,
    "truth, by a C library": lambda: libc_open(os.path.join(TRUTH, "cell.py")),
    "truth, uncovered": uncover,
    "truth, in namespaces of its own": lambda: started("unshare", "-Urm", "sh", "-c", SHELL),
    "home, by Python": lambda: open(SECRET),
    "home, by a C library": lambda: libc_open(SECRET),
    "home, by pyarrow": lambda: arrow_open(SECRET),
    "home, by another process": lambda: started("cat", SECRET),
    "home, by a disk": lambda: os.mknod("disk", 0o60600, DISK),
    "another process": lambda: os.kill(PARENT, 0),
    "the network": lambda: connect(socket.AF_INET, ("127.0.0.1", PORT)),
    "a local socket": lambda: connect(socket.AF_UNIX, LOCAL),
    "a local socket without a file": lambda: connect(socket.AF_UNIX, ABSTRACT),
    "libraries, to write": written,
}
reached = []
for what, attempt in TRIED.items():
    try:
        attempt()
    except (ImportError, OSError):
        pass
    else:
        reached.append(what)
"""
"""What an agent does to find more than it is given."""


def reached(tmp_path):
    """What an agent reaches of the truth, of files, processes and networks."""
    secret, local, abstract = tmp_path / "secret.txt", tmp_path / "local", f"\0ffgym-test-{os.getpid()}"
    secret.write_text("seen")
    with (
        socket.create_server(("127.0.0.1", 0)) as network,
        socket.socket(socket.AF_UNIX) as by_file,
        socket.socket(socket.AF_UNIX) as by_name,
    ):
        for server, place in ((by_file, str(local)), (by_name, abstract)):
            server.bind(place)
            server.listen()
        told = {
            "SECRET": str(secret),
            "TRUTH": str(Path(ffgym.__file__).resolve().parent / "workcell"),
            "DISK": os.stat(tmp_path).st_dev,
            "PARENT": os.getpid(),
            "PORT": network.getsockname()[1],
            "LOCAL": str(local),
            "ABSTRACT": abstract,
        }
        lines = [f"{name} = {value!r}" for name, value in told.items()]
        head = "\n".join([*lines, SEARCH, "raise ValueError(' / '.join(reached) or 'nothing')"])
        with pytest.raises(Refused) as caught:
            decide(agent_file(head=head))
    assert caught.value.reason.startswith("it raised ValueError: ")
    return caught.value.reason.removeprefix("it raised ValueError: ").partition(" (agent.py")[0].split(" / ")


@isolated
def test_an_isolated_agent_reaches_neither_truth_nor_files_nor_processes_nor_network(tmp_path):
    assert reached(tmp_path) == ["nothing"]


@isolated
def test_another_copy_of_the_package_is_covered_too(tmp_path, monkeypatch):
    data = tmp_path / "ffgym" / "workcell" / "data"
    data.mkdir(parents=True)
    monkeypatch.setattr("sys.path", [*sys.path, str(tmp_path)])
    assert str(data.parent) in processes._bubble(tmp_path)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the attempts are those of Linux")
def test_without_isolation_the_same_agent_reaches_all_that_its_user_does(tmp_path, monkeypatch):
    monkeypatch.setattr(processes, "_exposed", lambda: "not in this test")
    wanted = {
        "truth, by import",
        "truth, on the path of Python",
        "truth, by a C library",
        "home, by Python",
        "home, by a C library",
        "home, by another process",
        "another process",
        "the network",
        "a local socket",
        "a local socket without a file",
    }
    assert wanted <= set(reached(tmp_path))


@isolated
def test_an_isolated_agent_may_write_in_its_own_folder():
    assert decide(agent_file(head="open('notes.txt', 'w').write('mine')")).shape == (1, 1, 6)


def test_one_sentence_says_where_nothing_isolates(monkeypatch):
    monkeypatch.setattr(processes, "_exposed", lambda: "no program bwrap")
    monkeypatch.delenv(processes.DECLARED, raising=False)
    assert "Nothing isolates agents here (no program bwrap)" in processes.isolation_note()
    assert processes.describe_isolation() == "none: no program bwrap"
    monkeypatch.setenv(processes.DECLARED, "container")
    assert processes.isolation_note() is None
    assert processes.describe_isolation() == "declared: container"
    monkeypatch.setattr(processes, "_exposed", lambda: None)
    assert processes.describe_isolation() == "bubblewrap"


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
