"""Formats whose libraries are no part of the core: each is imported with the first file of its kind."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ffgym.core.errors import FFGymError
from ffgym.logs.contents import Contents


@contextmanager
def _extra(what: str, package: str) -> Iterator[None]:
    """Say which extra is missing if an import within fails."""
    try:
        yield
    except ImportError as error:
        raise FFGymError(f"Reading {what} needs {package}; pip install 'ffgym[logs]'.") from error


def read_mat73(data: bytes, where: str) -> Contents:
    """See `ffgym.logs.formats.hdf5.read_mat73`."""
    with _extra("MATLAB files of version 7.3", "h5py"):
        from ffgym.logs.formats.hdf5 import read_mat73 as read
    return read(data, where)


def read_hdf5(data: bytes, where: str) -> Contents:
    """See `ffgym.logs.formats.hdf5.read_hdf5`."""
    with _extra("HDF5 files", "h5py"):
        from ffgym.logs.formats.hdf5 import read_hdf5 as read
    return read(data, where)


def read_parquet(data: bytes, where: str) -> Contents:
    """See `ffgym.logs.formats.parquet.read_parquet`."""
    with _extra("Parquet files", "pyarrow"):
        from ffgym.logs.formats.parquet import read_parquet as read
    return read(data, where)


def read_lerobot(folder: Path) -> Contents:
    """See `ffgym.logs.formats.lerobot.read_lerobot`."""
    with _extra("LeRobot data sets", "pyarrow"):
        from ffgym.logs.formats.lerobot import read_lerobot as read
    return read(folder)


def read_bag(path: Path) -> Contents:
    """See `ffgym.logs.formats.rosbag.read_bag`."""
    with _extra("MCAP files and rosbags", "rosbags"):
        from ffgym.logs.formats.rosbag import read_bag as read
    return read(path)
