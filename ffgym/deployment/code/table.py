"""Tables of a law along one motion, for what cannot run code: CSV, and a binary file with a reader in C99.

The binary file is little-endian. Numbers are 8 bytes (IEEE 754) unless said otherwise:

    0   8 bytes           FFGYMTB1
    8   4 bytes, whole    1 (tells the order of bytes)
    12  4 bytes, whole    joints N
    16  4 bytes, whole    quantities Q
    20  4 bytes, whole    samples T
    24  number            time between samples [s]
    32  Q x 32 bytes      names of the quantities with their units, zero-terminated
    ..  T x Q x N numbers sample by sample, quantity by quantity, joint by joint
"""

import csv
import io
import os
import struct
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import numpy as np

from ffgym.control import FeedForwardLaw, invert_servo
from ffgym.control.corrections import check_invertible
from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.core.files import csv_rows, new_folder, read_bytes, read_text, write_bytes, write_text
from ffgym.core.types import Array
from ffgym.deployment.plan import SetpointPlan
from ffgym.paths import Reference

_MAGIC, _NAME = b"FFGYMTB1", 32


@dataclass(frozen=True, kw_only=True, eq=False)
class LawTable:
    """Quantities of one motion, sampled evenly."""

    joints: tuple[str, ...]
    dt: float
    """Time between samples [s]."""
    values: Mapping[str, Array]
    """Quantities by name, with the unit in brackets, shape (T, N) each."""

    def __post_init__(self) -> None:
        check_number("time between samples", self.dt, unit="s", low=0.0, open_low=True)
        if not self.values or not self.joints:
            raise FFGymError("A table needs one quantity or more, and one joint or more.")
        shape = (len(next(iter(self.values.values()))), len(self.joints))
        for name, array in self.values.items():
            check_shape(name, array, shape)
            if len(name.encode()) >= _NAME:
                raise FFGymError(f"Name {name!r} of a quantity must be shorter than {_NAME} bytes.")

    @classmethod
    def along(cls, law: FeedForwardLaw, reference: Reference) -> "LawTable":
        """Tabulate a law along a motion: position, torque, and the correction of set-points that gives this torque.

        A servo without gains on a joint follows no correction; the table has none then.
        """
        robot, torque = reference.robot, law.torque(reference)
        values = {"position [rad or m]": reference.q, "torque [N m]": torque}
        with suppress(FFGymError):
            check_invertible(robot.servo)
            values["correction [rad or m]"] = robot.drive.joint_angle(invert_servo(robot.servo, torque))
        return cls(joints=tuple(robot.joints), dt=robot.servo.control_dt, values=values)

    @classmethod
    def of_plan(cls, plan: SetpointPlan) -> "LawTable":
        """Tabulate a plan of set-points."""
        values = {
            "position [rad or m]": plan.program,
            "torque [N m]": plan.torque,
            "correction [rad or m]": plan.correction,
        }
        return cls(joints=plan.joints, dt=plan.dt, values=values)


def write_table(table: LawTable, path: str | os.PathLike[str]) -> None:
    """Write a folder with `table.csv`, `table.bin` and its reader `table.h`; both are read back and compared.

    Raises:
        FFGymError: if the folder cannot be written, or a file does not give back every bit.
    """
    with new_folder(path) as folder:
        write_text(folder / "table.csv", _csv_text(table))
        write_bytes(folder / "table.bin", _encode(table))
        reader = resources.files("ffgym.deployment.code") / "templates" / "table.h"
        write_text(folder / "table.h", reader.read_text(encoding="utf-8"))
        for name in ("table.csv", "table.bin"):
            found = read_table(folder / name)
            same = [*found.values] == [*table.values] and found.dt == table.dt and found.joints == _known(table, name)
            if not same or not all(np.array_equal(found.values[key], table.values[key]) for key in table.values):
                raise FFGymError(f"{name} does not give back what was written. The disk may be damaged.")


def _known(table: LawTable, name: str) -> tuple[str, ...]:
    """Names of joints that a file keeps: the binary one numbers them."""
    return table.joints if name.endswith(".csv") else tuple(f"joint_{j + 1}" for j in range(len(table.joints)))


def read_table(path: str | os.PathLike[str]) -> LawTable:
    """Read a table, `.csv` or binary.

    Raises:
        FFGymError: if the file cannot be read, or is no such table.
    """
    try:
        return _parse(read_text(path)) if Path(path).suffix == ".csv" else _decode(read_bytes(path))
    except (ValueError, IndexError, struct.error) as error:
        raise FFGymError(f"{path}: is no table of a law: {error}. Write it again: ffgym export table.") from error


def _csv_text(table: LawTable) -> str:
    """Columns `t [s]` and `<quantity>.<joint> [<unit>]`, a row for each sample."""
    names = ["t [s]"]
    for quantity in table.values:
        name, unit = quantity.split(" ", 1)
        names += [f"{name}.{joint} {unit}" for joint in table.joints]
    count = len(next(iter(table.values.values())))
    rows = np.concatenate([np.arange(count)[:, None] * table.dt, *table.values.values()], axis=1)
    return ",".join(names) + "\n" + csv_rows(rows)


def _parse(text: str) -> LawTable:
    head, _, body = text.partition("\n")
    names = next(csv.reader([head]), [])
    if not body.strip():
        raise ValueError("it has no rows")
    rows = np.loadtxt(io.StringIO(body), delimiter=",", ndmin=2)
    if not names or names[0] != "t [s]" or rows.shape[1] != len(names) or len(rows) < 2:
        raise ValueError("its columns are others")
    columns: dict[str, dict[str, Array]] = {}
    for name, column in zip(names[1:], rows.T[1:], strict=True):
        place, unit = name.split(" ", 1)
        quantity, joint = place.split(".", 1)
        columns.setdefault(f"{quantity} {unit}", {})[joint] = column
    joints = tuple(next(iter(columns.values())))
    values = {name: np.stack([*each.values()], axis=1) for name, each in columns.items()}
    return LawTable(joints=joints, dt=float(rows[1, 0] - rows[0, 0]), values=values)


def _encode(table: LawTable) -> bytes:
    values = np.stack([*table.values.values()], axis=1)  # (T, Q, N)
    samples, quantities, n = values.shape
    head = struct.pack("<8s4Id", _MAGIC, 1, n, quantities, samples, table.dt)
    names = b"".join(name.encode().ljust(_NAME, b"\0") for name in table.values)
    return head + names + values.astype("<f8").tobytes()


def _decode(data: bytes) -> LawTable:
    magic, order, n, quantities, samples, dt = struct.unpack_from("<8s4Id", data)
    start = 32 + _NAME * quantities
    if magic != _MAGIC or order != 1 or len(data) != start + 8 * samples * quantities * n:
        raise ValueError("its head or its length is another")
    names = [data[32 + _NAME * k : 32 + _NAME * (k + 1)].rstrip(b"\0").decode() for k in range(quantities)]
    values = np.frombuffer(data, dtype="<f8", offset=start).reshape(samples, quantities, n).astype(np.float64)
    joints = tuple(f"joint_{j + 1}" for j in range(n))
    return LawTable(joints=joints, dt=dt, values={name: values[:, k] for k, name in enumerate(names)})
