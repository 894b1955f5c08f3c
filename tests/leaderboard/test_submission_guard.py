"""An agent in its own process gets observations and nothing else; what it tries beyond is the reason it is refused."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ffgym.leaderboard.submission.judge import Judge
from ffgym.leaderboard.submission.refusal import Refused
from tests.leaderboard.submission_samples import agent_file, process
from tests.processes import is_alive, waited

PACKAGE = Path(__file__).parents[2] / "ffgym"
LAYOUT_SIZE = 9 * 6
"""Errors, last torque, and three numbers of two samples of the reference for each motor."""


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


@pytest.mark.parametrize(
    ("head", "body", "reason"),
    [
        ("import ffgym.workcell", "pass", "tried to import ffgym.workcell"),
        ("", "import ffgym.envs", "tried to import ffgym.envs"),
        ("", "import ffgym.simulation", "tried to import ffgym.simulation"),
        ("from ffgym.studies import in_mm", "pass", "tried to import ffgym.studies"),
        (
            "import contextlib\nwith contextlib.suppress(BaseException):\n    from scripts.exam import draw",
            "pass",
            "tried to import scripts.exam",
        ),
        (
            "import importlib, sys",
            "sys.meta_path[:] = [each for each in sys.meta_path if 'NoImports' not in repr(each)]\n"
            "try:\n    importlib.import_module('ffgym.workcell')\nexcept BaseException:\n    pass",
            "tried to",
        ),
        ("import gymnasium", "gymnasium.make('ffgym/OneAxis-v0')", "tried to import ffgym.envs"),
        ("import atexit\natexit.register(lambda: open('/proc/self/environ'))", "pass", "tried to read /proc/"),
    ],
)
def test_an_agent_that_looks_for_the_simulator_is_refused_with_what_it_tried(head, body, reason):
    assert reason in outcome(agent_file(body, head))


@pytest.mark.skipif(not Path("/proc/self/mem").exists(), reason="no memory as files here")
def test_an_agent_that_reads_the_memory_of_the_simulator_is_refused():
    body = "import os\ntry:\n    open(f'/proc/{os.getppid()}/mem', 'rb')\nexcept OSError:\n    pass"
    assert f"tried to read /proc/{os.getpid()}/mem" in outcome(agent_file(body))


@pytest.mark.parametrize(
    ("event", "arguments", "tried"),
    [
        ("open", (str(PACKAGE / "workcell" / "cell.py"), "r", 0), "read"),
        ("open", (str(PACKAGE / "envs" / ".." / "exam" / "draw.py"), "r", 0), "read"),
        ("open", (PACKAGE / "leaderboard" / "plants.py", "r", 0), "read"),
        ("open", ("/elsewhere/ffgym/workcell/data/thesis.toml", "r", 0), "read"),
        ("open", ("ffgym/workcell/data/thesis.toml", None, os.O_RDONLY), "read"),
        ("open", (str(PACKAGE), None, os.O_RDONLY), "open the folder"),
        ("open", (str(PACKAGE.parent / "scripts" / "quickstart.py"), "r", 0), "read"),
        ("open", (str(PACKAGE.parent / "tests" / "processes.py"), "r", 0), "read"),
        ("open", (b"/proc/1/environ", None, os.O_RDONLY), "read /proc/1/environ"),
        ("open", ("/dev/mem", "rb", 0), "read /dev/mem"),
        ("open", ("elsewhere/file", "w", 0), "outside of its folder"),
        ("open", ("/elsewhere/file", None, os.O_CREAT | os.O_WRONLY), "outside of its folder"),
        ("os.rename", ("/a", "/b", -1, -1), "outside of its folder"),
        ("os.listdir", ("/proc",), "read /proc"),
        ("import", ("ffgym.workcell.cell", None, [], [], []), "import ffgym.workcell.cell"),
        ("import", ("ffgym.leaderboard.plants", None, [], [], []), "import ffgym.leaderboard.plants"),
        ("ctypes.dlopen", ("libc.so.6",), "ctypes"),
        ("subprocess.Popen", ("ls", ["ls"], None, None), "start a process"),
        ("os.fork", (), "start a process"),
        ("_winapi.CreateProcess", (None, "ls", None), "start a process"),
        ("os.kill", (1, 9), "send a signal"),
        ("socket.connect", (None, ("127.0.0.1", 80)), "open a network connection"),
    ],
)
def test_what_an_agent_must_not_do_is_said_in_words(event, arguments, tried, tmp_path):
    assert tried in Judge(tmp_path)(event, arguments)


@pytest.mark.parametrize(
    ("event", "arguments"),
    [
        ("open", (3, "r", 0)),
        ("open", (os.__file__, "r", os.O_RDONLY)),
        ("open", (str(PACKAGE / "control" / "policy.py"), "rb", os.O_RDONLY)),
        ("open", ("/proc/cpuinfo", "r", 0)),
        ("open", ("/proc/self/maps", "r", 0)),
        ("open", (os.devnull, "w", os.O_WRONLY)),
        ("os.listdir", (None,)),
        ("import", ("ffgym.control", None, [], [], [])),
        ("import", ("ffgym.agents.elastic", None, [], [], [])),
        ("compile", (b"", "<string>")),
    ],
)
def test_what_every_library_does_is_allowed(event, arguments, tmp_path):
    assert Judge(tmp_path)(event, arguments) is None


def test_an_agent_may_write_in_its_own_folder_and_open_it(tmp_path):
    assert Judge(tmp_path)("open", (str(tmp_path / "notes.txt"), "w", 0)) is None
    assert Judge(tmp_path)("open", (str(tmp_path), None, os.O_RDONLY)) is None


CHILD = "import time; time.sleep(30)"
SWALLOWED = "try:\n    {}\nexcept BaseException:\n    pass"


@pytest.mark.parametrize(
    "starts",
    [
        f"import multiprocessing.util, sys; multiprocessing.util.spawnv_passfds(sys.executable.encode(), "
        f"[sys.executable, '-c', {CHILD!r}], ())",
        "import multiprocessing; multiprocessing.get_context('spawn').Process(target=print).start()",
        "from concurrent.futures import ProcessPoolExecutor as Pool; import multiprocessing; "
        "Pool(1, multiprocessing.get_context('spawn')).submit(print).result()",
        "import subprocess; subprocess._fork_exec()",
        "import _posixsubprocess; _posixsubprocess.fork_exec()",
    ],
)
@pytest.mark.skipif(os.name != "posix", reason="processes start with an event here")
def test_an_agent_that_starts_a_process_past_the_events_is_refused_though_it_swallows_that(starts):
    assert "tried to start a process" in outcome(agent_file(head=SWALLOWED.format(starts)))


def test_what_starts_processes_is_not_loaded_afresh():
    again = "import sys; del sys.modules['_posixsubprocess']; import _posixsubprocess"
    assert "tried to import _posixsubprocess" in outcome(agent_file(head=SWALLOWED.format(again)))


def test_an_agent_may_ask_on_which_platform_it_is():
    with process(agent_file(head="import platform\nplatform.platform()")) as agent:
        assert agent.preview == 1


def test_an_agent_may_use_the_threads_of_scikit_learn():
    pytest.importorskip("sklearn")
    head = "from sklearn.cluster import KMeans\nKMeans(n_clusters=2, n_init=1).fit(np.arange(12.0).reshape(6, 2))"
    with process(agent_file(head=head)) as agent:
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
