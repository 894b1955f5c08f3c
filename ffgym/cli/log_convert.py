"""`ffgym log convert`: a file of another tool as recordings."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tyro

from ffgym.cli.outputs import check_outputs, provenance
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import write_json
from ffgym.logs import read_logs
from ffgym.recordings import Recording, write_recording
from ffgym.recordings.io import FORMATS


@dataclass(frozen=True)
class Convert:
    """Make recordings of the motions in a file, as a column map says what it holds."""

    log: tyro.conf.Positional[Path]
    """CSV or other text, NPZ, MAT, HDF5, Parquet, MCAP or rosbag file; a folder of a rosbag or a LeRobot data set."""
    columns: str
    """Column map: a built-in name, or a file that ends in .toml; `ffgym log columns` writes a draft."""
    out: Path
    """Recording to write, .npz or .csv; with several motions each has its own file, its name before the suffix."""
    robot: str | None = None
    """Built-in robot, or a description (.toml), for a map that names none."""
    json: Path | None = None
    """Also write what was converted to this file."""

    def run(self) -> None:
        """Check, read, write, print."""
        check_choice("recording format", self.out.suffix, list(FORMATS))
        inputs = (self.log, self.columns, self.robot)
        check_outputs({"--out": self.out, "--json": self.json}, inputs=inputs)
        recordings = read_logs(self.log, self.columns, robot=self.robot)
        places = self._places(recordings)
        check_outputs({f"--out of {name}": place for name, place in places.items()}, inputs=inputs)
        for recording, place in zip(recordings, places.values(), strict=True):
            write_recording(recording, place)
        if self.json is not None:
            info = provenance("ffgym log convert", self, recordings[0].header.robot, None, None)
            listed = zip(recordings, places.values(), strict=True)
            write_json(self.json, info | {"recordings": [_numbers(r, place) for r, place in listed]})
        for recording, place in zip(recordings, places.values(), strict=True):
            print(_line(recording, place))
        for name in recordings[0].header.provenance.get("left_out", []):
            print(f"note: {name} is left out, the file has nothing for it")
        if self.json is not None:
            print(f"numbers: {self.json}")

    def _places(self, recordings: list[Recording]) -> dict[str, Path]:
        """Where the recording of each motion goes."""
        segments = [recording.header.segment for recording in recordings]
        if len(segments) == 1:
            return {segments[0]: self.out}
        names = [re.sub(r"[^\w.-]", "_", segment) for segment in segments]  # a segment may hold anything
        places = {s: self.out.with_stem(f"{self.out.stem}_{name}") for s, name in zip(segments, names, strict=True)}
        if len(set(places.values())) < len(recordings):
            raise FFGymError(f"Motions {', '.join(segments)} need names that make different file names.")
        return places


def _line(recording: Recording, place: Path) -> str:
    header = recording.header
    span = f"{len(recording)} rows, {recording.t[-1] - recording.t[0]:.6g} s at {1 / recording.dt:.6g} Hz"
    return f"{place}: {header.segment}, robot {header.robot}, {span}: {', '.join(recording.families)}"


def _numbers(recording: Recording, place: Path) -> dict[str, Any]:
    header = recording.header
    return {
        "recording": str(place),
        "segment": header.segment,
        "robot": header.robot,
        "rows": len(recording),
        "start_s": float(recording.t[0]),
        "end_s": float(recording.t[-1]),
        "period_s": recording.dt,
        "columns": list(recording.columns),
        "source": header.provenance,
    }
