"""Tables of a law come back with every bit, in Python and in C."""

import ctypes
import struct
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ffgym.control import StaticLuGre
from ffgym.core.errors import FFGymError
from ffgym.deployment import LawTable, SetpointPlan, read_table, write_table
from ffgym.deployment.code.compiler import compile_c, find_compiler
from ffgym.deployment.code.table import _decode, _encode
from ffgym.paths.motions import load_motion
from ffgym.robot import RigidArm, load_robot


@pytest.fixture(scope="module")
def table():
    robot = load_robot("irb4600_60_205")
    return LawTable.along(StaticLuGre(robot.friction), load_motion(RigidArm(robot), "circles").reference)


def test_a_table_has_the_torque_of_the_law_and_the_correction_that_gives_it(table):
    robot = load_robot("irb4600_60_205")
    reference = load_motion(RigidArm(robot), "circles").reference
    torque = StaticLuGre(robot.friction).torque(reference)
    assert np.array_equal(table.values["torque [N m]"], torque)
    assert np.array_equal(table.values["position [rad or m]"], reference.q)
    # the servo makes the torque of the correction, but for the samples in which friction changes its sign
    correction, servo, dt = robot.drive.motor_angle(table.values["correction [rad or m]"]), robot.servo, table.dt
    integral = np.cumsum(0.5 * dt * (correction[1:] + correction[:-1]), axis=0)
    speed = np.diff(correction, axis=0) / dt
    given = servo.position_gain * correction[1:] + servo.velocity_gain * speed + servo.integral_gain * integral
    assert np.median(np.abs(given - torque[1:])) < 0.01 * np.abs(torque).max()
    assert np.median(np.abs(given)) > 0.1 * np.abs(torque).max()


def test_a_written_table_comes_back_with_every_bit(table, tmp_path):
    write_table(table, tmp_path / "table")
    assert sorted(path.name for path in (tmp_path / "table").iterdir()) == ["table.bin", "table.csv", "table.h"]
    for name in ("table.csv", "table.bin"):
        back = read_table(tmp_path / "table" / name)
        assert back.dt == table.dt
        assert all(np.array_equal(back.values[key], table.values[key]) for key in table.values)
    assert read_table(tmp_path / "table" / "table.csv").joints == table.joints


def test_a_table_of_a_plan_has_its_correction(tmp_path):
    program = np.arange(6.0).reshape(3, 2)
    plan = SetpointPlan(
        name="line",
        robot="two_axes",
        law="elastic",
        joints=("a", "b"),
        units=("rad", "m"),
        dt=0.012,
        program=program,
        correction=1e-3 * program,
        torque=2 * program,
    )
    write_table(LawTable.of_plan(plan), tmp_path / "table")
    back = read_table(tmp_path / "table" / "table.csv")
    assert np.array_equal(back.values["correction [rad or m]"], plan.correction)
    assert (back.joints, back.dt) == (("a", "b"), 0.012)


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_the_reader_in_c_gives_every_number_and_refuses_other_bytes(table, tmp_path):
    write_table(table, tmp_path / "table")
    (tmp_path / "reader.c").write_text(
        '#include "table/table.h"\n'
        "int all(const unsigned char *bytes, unsigned long size, const char *name, double *out) {\n"
        "    table t;\n"
        "    if (table_open(&t, bytes, size) != 0) return 1;\n"
        "    const int q = table_find(&t, name);\n"
        "    for (unsigned k = 0; k <= t.samples; ++k)\n"
        "        for (unsigned j = 0; j < t.joints; ++j)\n"
        "            out[k * t.joints + j] = table_at(&t, q, k, j);\n"
        "    return q < 0 ? 2 : 0;\n"
        "}\n"
    )
    flags = ("-Wall", "-Wextra", "-pedantic", "-Werror", "-shared", "-fPIC")
    compile_c(find_compiler(), [tmp_path / "reader.c"], tmp_path / "reader.so", *flags)
    function = ctypes.CDLL(str(tmp_path / "reader.so")).all
    data = (tmp_path / "table" / "table.bin").read_bytes()

    def read(data: bytes, name: str):
        found = np.zeros((len(table.values["torque [N m]"]) + 1, 6))
        size = ctypes.c_ulong(len(data))
        return function(data, size, name.encode(), found.ctypes.data_as(ctypes.c_void_p)), found

    for name, wanted in table.values.items():
        code, found = read(data, name)
        assert code == 0
        assert np.array_equal(found[:-1], wanted)
        assert np.array_equal(found[-1], wanted[-1])
    assert read(data, "speed [rad/s]")[0] == 2
    head = struct.Struct("<8s4Id")
    magic, order, n, quantities, samples, dt = head.unpack_from(data)
    wrong = [
        (n, quantities, samples + 1),
        (n, quantities + 1, samples),
        (n, 0, samples),
        (2**31, 2**30, 8),  # whose product is 0 in 64 bits
        (n, 2**32 - 1, samples),
    ]
    others = [head.pack(magic, order, *sizes, dt) + data[32:] for sizes in wrong]
    nothing = head.pack(magic, order, 2**31, 2, 2**31, dt) + bytes(64)  # names, and no numbers
    for other in (
        *others,
        data + bytes(8),
        data + bytes(8 * n),
        nothing,
        data[:-1],
        data[:40],
        data[:31],
        b"X" + data[1:],
        data[:8] + b"\0\0\0\1" + data[12:],
    ):
        assert read(other, "torque [N m]")[0] == 1


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**9), st.integers(1, 7), st.integers(2, 5), st.integers(1, 3))
def test_any_table_comes_back_from_its_bytes(seed, n, samples, quantities):
    rng = np.random.default_rng(seed)
    values = {f"x{k} [1]": rng.normal(size=(samples, n)) * 10.0 ** rng.integers(-300, 300) for k in range(quantities)}
    table = LawTable(joints=tuple(map(str, range(n))), dt=rng.uniform(1e-4, 1.0), values=values)
    back = _decode(_encode(table))
    assert back.dt == table.dt
    assert all(np.array_equal(back.values[key], values[key]) for key in values)


def test_a_table_that_is_none_is_refused(table, tmp_path):
    write_table(table, tmp_path / "table")
    whole = (tmp_path / "table" / "table.bin").read_bytes()
    for name, data in {"cut.bin": whole[:-8], "other.bin": b"nothing", "other.csv": b"a,b\n1,2\n"}.items():
        (tmp_path / name).write_bytes(data)
        with pytest.raises(FFGymError, match="is no table of a law"):
            read_table(tmp_path / name)
    with pytest.raises(FFGymError, match="shorter than 32 bytes"):
        replace(table, values={"x" * 40: table.values["torque [N m]"]})
    with pytest.raises(FFGymError, match="one quantity or more"):
        replace(table, values={})
