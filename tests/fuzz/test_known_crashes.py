"""Files that once crashed a reader, hung it or filled the memory: each gives one clear error now, and stays so."""

import gzip
import json
import os
import signal
import sqlite3
import zipfile
from collections.abc import Callable
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import scipy.io

from ffgym.agents.artefacts import read_manifest
from ffgym.agents.law_files import load_law, pack
from ffgym.agents.residual.policy import load_policy
from ffgym.core import files
from ffgym.core.errors import LONGEST, FFGymError
from ffgym.deployment import read_plan
from ffgym.deployment.code.table import read_table
from ffgym.deployment.controller_file import read_servo
from ffgym.diagnosis.diagnosis_file import read_diagnosis
from ffgym.diagnosis.tables.table_file import load_table
from ffgym.leaderboard.adaptation.results import read_results
from ffgym.leaderboard.results import read_row
from ffgym.leaderboard.submission.rounds import read_round
from ffgym.logs import load_columns, read_contents
from ffgym.logs.quality import check_quality
from ffgym.paths import load_motion
from ffgym.paths.rapid.program import load_program
from ffgym.recordings import Recording, read_folder, read_recording
from ffgym.robot import RigidArm, load_robot
from ffgym.robot.arm_file.read import read_arm
from ffgym.simulation.plant.machine_file import load_machine
from scripts.fuzz.groups import load_readers
from scripts.fuzz.reader import make_valid
from scripts.fuzz.readers.samples import small_recording

NESTED = "[" * 100_000
"""Lists in lists, deeper than any parser goes by recursion."""
ALL = {reader.name: reader for readers in load_readers().values() for reader in readers}


class Crash(NamedTuple):
    """A file that crashed a reader."""

    make: Callable[[Path], Path]
    """Function that writes it into a folder."""
    read: Callable[[Path], Any]
    message: str
    """What the error says now, as a pattern."""


def write(name: str, content: str | bytes) -> Callable[[Path], Path]:
    """Make a file of this content."""

    def make(folder: Path) -> Path:
        (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
        return folder / name

    return make


def changed(reader: str, change: Callable[[Path], None]) -> Callable[[Path], Path]:
    """Make the valid files of a reader of the harness, and change them."""

    def make(folder: Path) -> Path:
        path = ALL[reader].makes[0](folder)
        change(path)
        return path

    return make


def json_with(change: Callable[[Any], None]) -> Callable[[Path], None]:
    def apply(path: Path) -> None:
        tree = json.loads(path.read_text())
        change(tree)
        path.write_text(json.dumps(tree))

    return apply


def header_with(change: Callable[[Any], None]) -> Callable[[Path], None]:
    """Change the header of an NPZ file."""

    def apply(path: Path) -> None:
        with np.load(path) as file:
            arrays = dict(file)
        header = json.loads(str(arrays.pop("header")))
        change(header)
        path.write_bytes(pack(header, arrays))

    return apply


def text_with(old: str, new: str) -> Callable[[Path], None]:
    def apply(path: Path) -> None:
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new, 1))

    return apply


def npz_that_claims(size: int) -> Callable[[Path], None]:
    """Let the last entry of an archive say that it unpacks to so many bytes."""

    def apply(path: Path) -> None:
        data = bytearray(path.read_bytes())
        place = data.rfind(b"PK\x01\x02") + 24
        data[place : place + 4] = size.to_bytes(4, "little")
        path.write_bytes(bytes(data))

    return apply


def npz_with_head(shape: str) -> Callable[[Path], Path]:
    """Make an NPZ file with an array whose head says more than it has."""

    def make(folder: Path) -> Path:
        head = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}}}\n".encode()
        with zipfile.ZipFile(folder / "log.npz", "w") as archive:
            archive.writestr("t.npy", b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head + bytes(80))
        return folder / "log.npz"

    return make


def hdf5_of(shape: tuple[int, ...]) -> Callable[[Path], Path]:
    """Make an HDF5 file with a data set that was never written, but is said to be large."""

    def make(folder: Path) -> Path:
        with h5py.File(folder / "log.h5", "w") as group:
            group.create_dataset("q", shape=shape, dtype="f8", chunks=(1000,))
        return folder / "log.h5"

    return make


def no_topic(path: Path) -> None:
    """Take the names of the topics away, in a table that allows it."""
    with sqlite3.connect(path) as base:
        base.execute("create table free as select * from topics")
        base.execute("drop table topics")
        base.execute("alter table free rename to topics")
        base.execute("update topics set name = null")
    base.close()


def law_with(**settings: Any) -> Callable[[Path], None]:
    return header_with(lambda header: header["settings"].update(settings))


def arm(path: Path) -> Any:
    return load_motion(RigidArm(load_robot("irb4600_60_205")), path)


MJCF = "<mujoco><worldbody>{}<body name='a'><joint name='j'/><geom size='1'/></body></worldbody></mujoco>"
GRID = "<asset><hfield name='h' nrow='1000000' ncol='1000000' size='1 1 1 1'/></asset><worldbody>"

SQUARE = (resources.files("ffgym.paths.motions") / "data" / "square.toml").read_text(encoding="utf-8")

CRASHES: dict[str, Crash] = {
    # text that no parser gets to the end of
    "nested results": Crash(write("r.json", NESTED), read_row, "is not valid JSON"),
    "nested adaptation": Crash(write("a.json", NESTED), read_results, "is not valid JSON"),
    "nested round": Crash(write("r.json", NESTED), read_round, "is not valid JSON"),
    "nested diagnosis": Crash(write("d.json", NESTED), read_diagnosis, "is not valid JSON"),
    "nested header of a law": Crash(
        changed("law", lambda path: np.savez(path, header=np.array(NESTED))), load_law, "is not valid JSON"
    ),
    "nested header of a plan": Crash(
        changed("plan", lambda path: np.savez(path, header=np.array(NESTED))), read_plan, "is not valid JSON"
    ),
    "nested machine": Crash(write("m.toml", f"x = {NESTED}"), load_machine, "is not valid TOML"),
    "nested index": Crash(
        changed("session", lambda path: (path / "protocol.json").write_text(NESTED)), read_folder, "is not valid JSON"
    ),
    # numbers that no float holds, or no parser takes
    "400 digits in a diagnosis": Crash(
        changed("diagnosis", json_with(lambda tree: tree.update(threshold=10**400))), read_diagnosis, "a finite number"
    ),
    "400 digits in results": Crash(
        changed("results", json_with(lambda tree: tree["outcomes"][0].update(robot_seconds=10**400))),
        read_row,
        "robot_seconds = 1000.* must be a finite number",
    ),
    "400 digits in steps of training": Crash(
        changed("results", json_with(lambda tree: tree["outcomes"][0].update(env_steps=10**400))),
        read_row,
        "env_steps = 1000.* must be a whole number of 63 bits",
    ),
    "400 digits in a servo": Crash(
        changed("controller", text_with("position_gain = [", f"position_gain = [{10**400}, ")),
        lambda path: read_servo(path, load_robot("two_link")),
        "position_gain",
    ),
    "5000 digits in a column map": Crash(
        write("map.toml", f"[log]\nrobot = {'9' * 5000}\n"), load_columns, "is not valid TOML"
    ),
    # results that are none
    "errors of other numbers of motors": Crash(
        changed("results", json_with(lambda tree: tree["outcomes"][0]["cells"][0]["motor_rms_rad"].pop())),
        read_row,
        "motor_rms_rad has 5 or 6 numbers",
    ),
    "negative error": Crash(
        changed("results", json_with(lambda tree: tree["outcomes"][0]["cells"][0].update(max_mm=-1.0))),
        read_row,
        r"max_mm = -1\.0 is out of range",
    ),
    "infinite error": Crash(
        changed("results", text_with('"rms_mm": 0.06', '"rms_mm": Infinity')), read_row, "rms_mm = inf must be a finite"
    ),
    # settings of agents
    "text for the settings of a policy": Crash(
        changed("policy", header_with(lambda header: header.update(settings="all"))), load_policy, "must be an object"
    ),
    "text for the actor of a policy": Crash(
        changed("policy", law_with(actor="mine")), load_policy, "actor = 'mine' must be an object"
    ),
    "text for what a policy tells": Crash(
        changed("policy", header_with(lambda header: header.update(meta="x"))), load_policy, "meta = 'x'"
    ),
    "number for the base of a policy": Crash(changed("policy", law_with(base=3)), load_policy, "base = 3 .* text"),
    "list for the file of an agent": Crash(
        changed(
            "manifest_of_agents",
            lambda path: json_with(lambda tree: tree["artefacts"][0].update(file=["x"]))(
                path / "narx" / "manifest.json"
            ),
        ),
        lambda path: read_manifest.__wrapped__("narx", path),
        r"file = \['x'\] must be text",
    ),
    # files in the place of others
    "name of 300 characters in an index": Crash(
        changed(
            "session", lambda path: json_with(lambda t: t["motions"][0].update(file="x" * 300))(path / "protocol.json")
        ),
        read_folder,
        "1 of 2 recordings are missing",
    ),
    # what asks for memory or time without end
    "recording that unpacks to 2 GB": Crash(
        changed("recording_npz", npz_that_claims(2**31)), read_recording, "would unpack to 2147.* Cut it into shorter"
    ),
    "array of 10^12 numbers with 10 of them": Crash(
        npz_with_head("(1000000000000,)"), read_contents, "Damaged, cut short, not NPZ"
    ),
    "array of no rows and 10^40 columns": Crash(npz_with_head(f"(0, {10**40})"), read_contents, "Damaged, cut short"),
    "table of 1 GB in 1 MB": Crash(
        write("log.csv.gz", gzip.compress(bytes(2**22), 1) * 256), read_contents, "would unpack to"
    ),
    "data set of 10^12 numbers": Crash(hdf5_of((10**12,)), read_contents, "would unpack to 8000"),
    "replicate of 10^8": Crash(
        write("arm.xml", MJCF.format("<replicate count='100000000'><body><geom size='1'/></body></replicate>")),
        read_arm,
        "stands for more than 100000 elements",
    ),
    "replicate of 999 in 999 of them": Crash(
        write(
            "arm.xml", MJCF.format("<replicate count='1000'><replicate count='1000'><geom/></replicate></replicate>")
        ),
        read_arm,
        "stands for more than 100000 elements",
    ),
    "replicate in what is no XML": Crash(
        write("arm.xml", "<mujoco a='1' a='2'>" + "<replicate count='100000000'><geom size='1'/></replicate></mujoco>"),
        read_arm,
        "stands for more than 100000 elements",
    ),
    "grid of 10^12": Crash(write("arm.xml", MJCF.format("").replace("<worldbody>", GRID)), read_arm, "nrow x ncol is"),
    "zone of 1e-302 m": Crash(
        write("motion.toml", SQUARE.replace("zone = 0.01", "zone = 1e-302")), arm, "A piece of a curve"
    ),
    "30,000 wrong signs in a program": Crash(
        changed("rapid", text_with("FROM", "FR" + "~" * 30_000)), load_program, "expected FROM"
    ),
    # odds and ends
    "number in place of positions that are alike": Crash(
        changed("error_table", text_with('["p1", "p2"]', "3")), load_table, r"alike = \[3\] must be a list of lists"
    ),
    "table of a law without rows": Crash(write("law.csv", "t [s],torque.j1 [N m]\n"), read_table, "it has no rows"),
}


@pytest.mark.parametrize("name", CRASHES)
def test_what_crashed_a_reader_is_one_clear_error(name, tmp_path):
    crash = CRASHES[name]
    path = crash.make(tmp_path)
    with within(10.0), pytest.raises(FFGymError, match=crash.message) as error:
        crash.read(path)
    assert len(str(error.value)) <= LONGEST


class within:
    """Block that may take some seconds, and no more."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds

    def __enter__(self) -> None:
        def late(*_: object) -> None:
            raise TimeoutError(f"it took more than {self.seconds} s")

        self.before = signal.signal(signal.SIGALRM, late)
        signal.setitimer(signal.ITIMER_REAL, self.seconds)

    def __exit__(self, *_: object) -> None:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, self.before)


def in_place_of(kind: str, path: Path) -> None:
    """Put something that is no file in the place of one."""
    path.unlink()
    if kind == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to("/dev/zero")


@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_no_reader_waits_for_a_pipe_or_reads_a_device_without_end(kind, tmp_path):
    for reader in ALL.values():
        if reader.name.startswith("packets"):  # which are read from no file
            continue
        folder = tmp_path / reader.name
        (one, *_) = make_valid(reader, tmp_path / "made")
        main = one.write(folder)
        read_first = main if main.is_file() else next(folder / name for name in sorted(one.files) if ".json" in name)
        in_place_of(kind, read_first)
        with within(5.0), pytest.raises(FFGymError):
            reader.use(main)


@pytest.mark.parametrize(
    ("name", "write"),
    [
        ("log.mat", lambda path: scipy.io.savemat(path, {"q": np.zeros(10**5)}, do_compression=True)),
        ("log.parquet", lambda path: pq.write_table(pa.table({"q": np.zeros(10**5)}), path)),
        ("log.h5", lambda path: hdf5_of((10**5,))(path.parent)),
        ("log.npz", lambda path: np.savez_compressed(path, q=np.zeros(10**5))),
        ("log.csv.gz", lambda path: path.write_bytes(gzip.compress(b"t\n" + b"0.0\n" * 10**5))),
    ],
)
def test_a_packed_log_may_unpack_to_a_limit(name, write, tmp_path, monkeypatch):
    write(tmp_path / name)
    assert list(read_contents(tmp_path / name))
    monkeypatch.setattr(files, "LARGEST_UNPACKED", 10**5)
    with pytest.raises(FFGymError, match=r"would unpack to .* must be at most"):
        read_contents(tmp_path / name)


def test_a_clock_in_seconds_that_is_read_as_nanoseconds_asks_for_no_memory():
    recording = small_recording()
    columns = dict(recording.columns) | {"timestamp": 1e-9 * recording.t}
    header = replace(recording.header, phases=())
    with within(10.0):
        (found,) = check_quality(Recording(columns, header)).of("clock_rate")
    assert found.verdict == "refused"
    assert "timestamp: rows are 4e-12 s apart" in found.message


def test_a_topic_without_a_name_is_left_out(tmp_path):
    path = ALL["log_db3"].makes[0](tmp_path)
    no_topic(path)
    contents = read_contents(path)
    assert all(isinstance(name, str) for name in (*contents, *contents.streams.values(), *contents.skipped))
