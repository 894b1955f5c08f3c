"""Commands in forks of one process that has loaded everything, ended at a chosen point of what they write.

Started as a process it reads orders from standard input, a line of JSON each, and answers each with another:
{"run": arguments, "at": point, "by": signal, "after": seconds} runs a command, and sends it a signal at a point or a
time; {"go on": pid} lets one go on that was stopped. A point is a call by which a command changes what is on the disk.
"""

import ctypes
import io
import json
import mmap
import os
import signal
import struct
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path

_CHANGES = {"os.rename": 0, "os.mkdir": 0, "os.remove": 0, "os.rmdir": 0}
"""Events of the interpreter that change what is on the disk, and the argument that says where."""
_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT


class Killing:
    """The process of commands, which work in the folder `run` of a place; all that they write is in this place.

    Args:
        place: an empty folder.
        setting: name of the module and function that is called once before, in the folder `stock` of the place.
    """

    def __init__(self, place, setting):
        self.place, self.folder = place, place / "run"
        for name in ("run", "stock", "tmp"):
            (place / name).mkdir()
        command = [sys.executable, "-m", "tests.contract.killing", str(place), setting]
        here = Path(__file__).parents[2]
        environment = os.environ | {"PYTHONPATH": str(here), "OMP_NUM_THREADS": "1"}
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=here, env=environment
        )
        self.ready = self._read()

    def run(self, *arguments, at=None, by=signal.SIGKILL, after=None, out=None, encoding="utf-8", mode=None):
        """Run a command; return code (negative: signal), points, seconds, pid, output and errors.

        Args:
            arguments: words of the command.
            at: point at which it gets a signal; None is none.
            by: the signal.
            after: time after which it is killed [s]; None is none.
            out: standard output: a device, `closed`, or `left` for a pipe that nobody reads; None is a file.
            encoding: encoding of standard output.
            mode: permissions of the working directory, which it then cannot go beyond, whoever its user is.
        """
        how = {"at": at, "by": int(by), "after": after, "out": out, "encoding": encoding, "mode": mode}
        return self._ask({"run": arguments} | how)

    def go_on(self, pid):
        """Let a stopped command go on; returns as `run`."""
        return self._ask({"go on": pid})

    def close(self):
        """End the process."""
        self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()

    def _ask(self, order):
        self._process.stdin.write(json.dumps(order) + "\n")
        self._process.stdin.flush()
        return self._read()

    def _read(self):
        line = self._process.stdout.readline()
        assert line, "the process of the commands has ended"
        return json.loads(line)


def _serve(place, setting):
    """Answer orders until there are none."""
    orders, answers = sys.stdin, os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    tempfile.tempdir = str(place / "tmp")
    _use_one_thread()
    module, _, function = setting.partition(":")
    os.chdir(place / "stock")
    getattr(import_module(module), function)()
    running, counter = {}, mmap.mmap(-1, 4)
    answers.write(json.dumps({}) + "\n")
    answers.flush()
    for line in orders:
        order = json.loads(line)
        if "run" in order:
            begun = time.monotonic()
            pid = _begin(place, order, counter)
            running[pid] = begun
        else:
            pid = order["go on"]
            os.kill(pid, signal.SIGCONT)
        _, status = os.waitpid(pid, os.WUNTRACED)
        code = -os.WSTOPSIG(status) if os.WIFSTOPPED(status) else os.waitstatus_to_exitcode(status)
        (points,) = struct.unpack("i", counter[:4])
        answer = {"code": code, "points": points, "seconds": time.monotonic() - running[pid], "pid": pid}
        answer |= {name: (place / f"{name}.{pid}").read_text() for name in ("out", "err")}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


def _use_one_thread():
    """Give the engine one thread, which a fork keeps."""
    from mujoco import batch

    begin = batch.Batch.__init__

    def begin_with_one(self, model, nsim, nthread=0, persistent=False):
        begin(self, model, nsim, 1, persistent)

    batch.Batch.__init__ = begin_with_one


def _begin(place, order, counter):
    """Begin a command in a fork; returns its pid."""
    pid = os.fork()
    if pid:
        return pid
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)
    _connect(place, order["out"], order["encoding"])
    os.chdir(place / "run")
    if order["mode"] is not None:
        os.chmod(".", order["mode"])
        _give_up_rights()
    sys.argv = ["ffgym", *order["run"]]
    counter[:4] = struct.pack("i", 0)
    _count(place, counter, order["at"], order["by"])
    if order["after"] is not None:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_REAL, order["after"])
    from ffgym.cli.main import main

    try:
        code = main(order["run"])
    except SystemExit as end:
        code = end.code
    except BaseException:
        import traceback

        traceback.print_exc()
        code = 70
    if sys.stdout is not None:
        sys.stdout.flush()
    os._exit(code or 0)


def _connect(place, out, encoding):
    """Connect the standard streams of this process to files, and the output to something else if it is named."""
    for number, name in ((1, "out"), (2, "err")):
        os.dup2(os.open(place / f"{name}.{os.getpid()}", os.O_WRONLY | os.O_CREAT), number)
    sys.stderr = io.TextIOWrapper(io.FileIO(2, "w", closefd=False), encoding="utf-8", write_through=True)
    if out == "closed":
        os.close(1)
        sys.stdout = sys.__stdout__ = None
        return
    if out == "left":
        read, write = os.pipe()
        os.close(read)
        os.dup2(write, 1)
    elif out is not None:
        os.dup2(os.open(out, os.O_WRONLY), 1)
    sys.stdout = sys.__stdout__ = io.TextIOWrapper(io.FileIO(1, "w", closefd=False), encoding=encoding)


def _give_up_rights():
    """Give up the right of root to pass by permissions."""
    header, none = struct.pack("Ii", 0x20080522, 0), bytes(24)
    assert ctypes.CDLL(None, use_errno=True).capset(header, none) == 0


def _count(place, counter, at, by):
    """Count points from now on, and send a signal to this process at one of them; a file is cut in half at a sync."""
    inside, sync, passed = [str(place / "run"), str(place / "tmp")], os.fsync, 0

    def pass_point(descriptor=None):
        nonlocal passed
        passed += 1
        counter[:4] = struct.pack("i", passed)
        if passed != at:
            return
        if descriptor is not None:
            os.ftruncate(descriptor, os.fstat(descriptor).st_size // 2)
        os.kill(os.getpid(), by)

    def listen(event, arguments):
        if event == "open":
            path, _, flags = arguments
            changes = bool(flags & _WRITES)
        else:
            path, changes = (arguments[_CHANGES[event]], True) if event in _CHANGES else (None, False)
        if not changes or isinstance(path, int):
            return
        name = os.path.abspath(os.fsdecode(path))
        if any(name.startswith(folder) for folder in inside):
            pass_point()

    def synchronise(descriptor):
        pass_point(descriptor if by == signal.SIGKILL else None)
        sync(descriptor)

    os.fsync = synchronise
    sys.addaudithook(listen)


@contextmanager
def process_of_commands(place, setting):
    """Yield a `Killing`, which ends with the block."""
    killing = Killing(place, setting)
    try:
        yield killing
    finally:
        with suppress(OSError):
            killing.close()


if __name__ == "__main__":
    _serve(Path(sys.argv[1]), sys.argv[2])
