import multiprocessing
import operator
import os
import signal
import subprocess
import sys
import time
from functools import partial

import pytest

from ffgym.core.errors import FFGymError, check_whole
from ffgym.core.executors import Executor
from ffgym.core.provenance import is_installed
from tests.processes import INTERRUPTIBLE, is_alive, waited


def square(x):
    return x * x


def refuse(x):
    raise FFGymError(f"x = {x} must be nothing.")


def refuse_late(x):
    if x:
        time.sleep(2.0)
        refuse(x)


def what_interrupts(x):
    return signal.Handlers(signal.getsignal(signal.SIGINT)).name


def die(x):
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_are_those_of_a_loop_whatever_the_number_of_processes(jobs):
    found = dict(Executor(jobs=jobs).run(square, [3, 1, 2]))
    assert found == {0: 9, 1: 1, 2: 4}


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_error_in_a_process_is_the_same_error_here(jobs):
    with pytest.raises(FFGymError, match="x = 1 must be nothing"):
        list(Executor(jobs=jobs).run(refuse, [1, 1]))


def test_a_process_that_is_killed_is_told_not_waited_for():
    with pytest.raises(FFGymError, match="A process that worked on a part has died"):
        list(Executor(jobs=2).run(die, [1, 2, 3]))


def test_nothing_to_do_is_done():
    assert list(Executor().run(square, [])) == []


def test_processes_end_when_the_one_that_began_them_is_killed(tmp_path):
    program = tmp_path / "sleepers.py"
    program.write_text(
        "import os, sys, time\n"
        "from pathlib import Path\n"
        "from ffgym.core.executors import Executor\n"
        "def sleep(folder):\n"
        "    (Path(folder) / f'{os.getpid()}.pid').touch()\n"
        "    time.sleep(60)\n"
        "if __name__ == '__main__':\n"
        "    list(Executor(jobs=2).run(sleep, [sys.argv[1]] * 2))\n"
    )
    process = subprocess.Popen([sys.executable, str(program), str(tmp_path)])
    try:
        workers = waited(lambda: pids(tmp_path) if len(pids(tmp_path)) == 2 else None)
    finally:
        process.kill()
        process.wait()
    assert waited(lambda: not any(is_alive(pid) for pid in workers))


def test_an_interruption_ends_the_processes_without_a_word_of_theirs(tmp_path):
    program = tmp_path / "sleepers.py"
    program.write_text(
        "import os, sys, time\n"
        "from pathlib import Path\n"
        "from ffgym.core.executors import Executor\n"
        "def sleep(task):\n"
        "    (Path(task[0]) / f'{os.getpid()}.pid').touch()\n"
        "    time.sleep(task[1])\n"
        "if __name__ == '__main__':\n"
        "    try:\n"
        "        list(Executor(jobs=3).run(sleep, [(sys.argv[1], wait) for wait in (60, 60, 1)]))\n"
        "    except KeyboardInterrupt:\n"
        "        print('interrupted')\n"
    )
    command = [sys.executable, str(program), str(tmp_path)]
    process = subprocess.Popen(
        command,
        start_new_session=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=INTERRUPTIBLE,
    )
    workers = waited(lambda: pids(tmp_path) if len(pids(tmp_path)) == 3 else None)
    time.sleep(1.5)  # one of them has nothing to do then
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    printed, complaints = process.communicate(timeout=30)
    assert printed == "interrupted\n"
    assert complaints == ""
    assert waited(lambda: not any(is_alive(pid) for pid in workers))


def test_workers_leave_an_interruption_to_who_hands_out_the_work():
    assert [found for _, found in Executor(jobs=2).run(what_interrupts, [0, 0])] == ["SIG_IGN", "SIG_IGN"]


def test_a_process_of_the_callers_own_survives():
    context = multiprocessing.get_context("spawn")
    before, meanwhile = (context.Process(target=time.sleep, args=(60,), daemon=True) for _ in range(2))
    before.start()
    try:
        with pytest.raises(FFGymError, match="x = 1 must be nothing"):
            [meanwhile.start() for _ in Executor(jobs=2).run(refuse_late, [0, 1])]
        time.sleep(0.5)
        assert before.is_alive()
        assert meanwhile.is_alive()
    finally:
        for process in (before, meanwhile):
            process.kill()


def pids(folder):
    return [int(path.stem) for path in folder.glob("*.pid")]


def test_an_address_without_ray_is_refused():
    with pytest.raises(FFGymError, match="choose the executor 'ray'"):
        Executor(address="auto")


def test_an_unknown_executor_is_refused():
    with pytest.raises(FFGymError, match="Unknown executor 'slurm'"):
        Executor(kind="slurm")


needs_ray = pytest.mark.skipif(not is_installed("ray"), reason="Ray is not installed")


@pytest.fixture(scope="module")
def ray():
    """A local Ray, begun once for all tests."""
    import ray

    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, configure_logging=False)
    yield ray
    ray.shutdown()


@needs_ray
@pytest.mark.filterwarnings("ignore")
def test_ray_gives_what_this_machine_gives(ray):
    assert dict(Executor(kind="ray").run(operator.neg, [3, 1, 2])) == {0: -3, 1: -1, 2: -2}
    assert dict(Executor(kind="ray", jobs=1).run(operator.neg, [3, 1, 2])) == {0: -3, 1: -1, 2: -2}
    with pytest.raises(FFGymError, match=r"x = 7.0 is out of range"):
        list(Executor(kind="ray").run(partial(check_whole, "x", low=0, high=5), [7]))
    with pytest.raises(TypeError, match="bad operand"):
        list(Executor(kind="ray").run(operator.neg, ["text"]))


@needs_ray
@pytest.mark.filterwarnings("ignore")
def test_a_ray_cluster_that_is_not_there_is_told(monkeypatch):
    import ray

    monkeypatch.setattr(ray, "is_initialized", lambda: False)
    with pytest.raises(FFGymError, match=r"No Ray cluster answers at '127.0.0.1:1': .*refused"):
        list(Executor(kind="ray", address="127.0.0.1:1").run(operator.neg, [1]))
