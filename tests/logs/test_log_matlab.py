"""MATLAB files of version 5 to 7, written by SciPy and by MATLAB, and of version 7.3."""

import io
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
from log_samples import decoded, refused
from scipy.sparse import csc_array

from ffgym.logs.formats.matlab import Matlab

Q = np.arange(12.0).reshape(4, 3) + 1 / 3
T = 0.004 * np.arange(4)
CUBE = np.arange(24, dtype=np.int16).reshape(2, 4, 3)
MATLABS_OWN = Path(scipy.io.__file__).parent / "matlab" / "tests" / "data"


def mat5(**variables):
    file = io.BytesIO()
    scipy.io.savemat(file, variables, do_compression=True)
    return file.getvalue()


def mat73(write):
    file = io.BytesIO()
    with h5py.File(file, "w", userblock_size=512) as group:
        write(group)
    return file.getvalue()


def read_mat(data):
    return decoded(Matlab(), data)


def test_arrays_and_structures_are_read_to_the_bit():
    runs = np.array([({"q": Q},), ({"q": 2 * Q},)], dtype=[("log", object)])
    cell = np.array([T, "text"], dtype=object)
    contents = read_mat(mat5(t=T, q=Q, cube=CUBE, log={"q": Q, "deep": {"gain": 2.5}}, runs=runs, c=cell, z=T + 1j))
    expected = {"t": T, "q": Q, "cube": CUBE, "log.q": Q, "log.deep.gain": 2.5, "runs(2).log.q": 2 * Q, "c{1}": T}
    for name, values in expected.items():
        np.testing.assert_array_equal(contents.numbers(name), values)
        assert contents[name].dtype == np.asarray(values).dtype
    assert contents["c{2}"] == "text"
    with refused("'z' is complex128, must be real numbers"):
        contents.numbers("z")


def test_a_sparse_matrix_says_what_to_do():
    with refused("'s' cannot be read: a sparse matrix; in MATLAB, save full(s)"):
        read_mat(mat5(s=csc_array(np.eye(3)), t=T))["s"]


def test_version_73_gives_the_same_names_and_axes():
    def write(file):
        for name, values in {"t": T[None], "q": Q, "cube": CUBE}.items():
            file[name] = values.T  # MATLAB counts axes the other way
        file["log/q"] = Q.T
        file["#refs#/a"], file["#refs#/b"] = T[None].T, (2 * Q).T
        for name, kind in (("c", b"cell"), ("runs/q", b"double")):
            references = file.create_dataset(name, (2, 1), dtype=h5py.ref_dtype)
            references[0, 0], references[1, 0] = file["#refs#/a"].ref, file["#refs#/b"].ref
            references.attrs["MATLAB_class"] = np.bytes_(kind)
        file["s"] = np.array([[ord(c) for c in "text"]], dtype=np.uint16).T
        file["s"].attrs["MATLAB_class"] = np.bytes_(b"char")
        file["empty"] = np.array([0, 0], dtype=np.uint64)
        file["empty"].attrs["MATLAB_empty"] = np.uint8(1)
        file["table"] = np.zeros(6, dtype=np.uint32)
        file["table"].attrs["MATLAB_object_decode"] = np.int32(3)

    contents = read_mat(mat73(write))
    expected = {"t": T, "q": Q, "cube": CUBE, "log.q": Q, "c{1}": T, "runs(2).q": 2 * Q, "empty": np.zeros(0)}
    for name, values in expected.items():
        np.testing.assert_array_equal(contents.numbers(name), values)
    assert contents["s"] == "text"
    with refused("'table' cannot be read: a MATLAB object (table, timeseries, string ...)"):
        contents["table"]


def test_links_that_lead_back_end():
    def write(file):
        file["t"] = T
        file["log/q"] = Q
        file["log/again"] = h5py.SoftLink("/")
        file["log/self"] = h5py.SoftLink("/log")

    assert set(read_mat(mat73(write))) == {"t", "log.q"}


@pytest.mark.skipif(not MATLABS_OWN.is_dir(), reason="SciPy is installed without its test files")
@pytest.mark.parametrize("version", ["5", "6", "7"])
def test_files_that_matlab_wrote_are_read(version):
    files = [file for file in MATLABS_OWN.glob(f"test*_{version}.*.mat") if file.name != "testhdf5_7.4_GLNX86.mat"]
    assert files
    for file in files:
        contents = read_mat(file.read_bytes())
        assert contents.arrays or contents.skipped, file.name
    assert read_mat((MATLABS_OWN / "testhdf5_7.4_GLNX86.mat").read_bytes())["testdouble"].shape == (9,)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"MATLAB", "Not a MATLAB file of version 5 or later, or cut short"),
        (mat5(t=T)[:-8], "Damaged or cut short: the element at byte 136 has"),
        (mat5(t=T)[:128], "The MATLAB file holds no variables"),
        (mat5(t=T)[:136] + bytes(200), "Damaged"),
        (b"\x89HDF\r\n\x1a\n" + bytes(100), "Not a MATLAB file, or damaged"),
    ],
)
def test_damage_is_one_error(data, message):
    with refused(message):
        read_mat(data)


def test_tags_on_which_the_library_would_crash_are_refused():
    file = io.BytesIO()
    scipy.io.savemat(file, {"q": Q}, do_compression=False)
    good = bytearray(file.getvalue())
    assert good[176] == 9  # type of the numbers of q: float64
    changes = ((176, 43, "of type 43, which"), (145, 8, "does not have the elements"), (144, 99, "is of class 99"))
    for place, value, message in changes:
        bad = good.copy()
        bad[place] = value
        with refused(message):
            read_mat(bytes(bad))
