"""`ffgym log columns`: what a file of another tool holds, and a draft of its column map."""

from dataclasses import dataclass
from pathlib import Path

import tyro

from ffgym.cli.outputs import check_outputs, provenance
from ffgym.core.errors import FFGymError
from ffgym.core.files import write_json, write_text
from ffgym.logs import TextLayout, read_contents
from ffgym.logs.draft import draft, listing
from ffgym.logs.entries import fitting_maps


@dataclass(frozen=True)
class Columns:
    """List the arrays in a file with shapes, types and ranges; write a draft of a column map to fill in."""

    log: tyro.conf.Positional[Path]
    """CSV or other text, NPZ, MAT, HDF5, Parquet, MCAP or rosbag file; a folder of a rosbag or a LeRobot data set."""
    out: Path | None = None
    """Draft to write, .toml."""
    force: bool = False
    """Write over a file that is there."""
    delimiter: str | None = None
    """Of a text file: what separates cells; none given takes what the first row holds."""
    decimal: str = "."
    """Of a text file: decimal point or comma."""
    encoding: str = "utf-8-sig"
    """Of a text file, e.g. latin-1."""
    names_row: int | None = None
    """Of a text file: line with the names of columns, from 1, 0 for none; none given takes the first that is text."""
    units_row: int | None = None
    """Of a text file: line with units, which is skipped."""
    json: Path | None = None
    """Also write what the file holds to this file."""

    def run(self) -> None:
        """Read, write, print."""
        if self.out is not None and self.out.suffix != ".toml":
            raise FFGymError(f"{self.out}: the suffix is {self.out.suffix!r}, a column map must end in .toml.")
        if self.out is not None and self.out.exists() and not self.force:
            raise FFGymError(f"{self.out} is there already, and may hold your work; --force writes over it.")
        check_outputs({"--out": self.out, "--json": self.json}, inputs=(self.log,))
        layout = TextLayout(
            delimiter=self.delimiter,
            decimal=self.decimal,
            encoding=self.encoding,
            names_row=self.names_row,
            units_row=self.units_row,
        )
        contents = read_contents(self.log, layout)
        if self.out is not None:
            write_text(self.out, draft(contents, layout))
        if self.json is not None:
            arrays = [{"name": n, "shape": list(a.shape), "type": str(a.dtype)} for n, a in contents.arrays.items()]
            info = provenance("ffgym log columns", self, "", None, None)
            found = {"arrays": arrays, "skipped": dict(contents.skipped), "maps": fitting_maps(contents)}
            write_json(self.json, info | found)
        print("\n".join(listing(contents)))
        for name in fitting_maps(contents):
            print(
                f"built-in map: {name} fits: ffgym log convert {self.log} --columns {name} --robot ROBOT --out FILE.npz"
            )
        if self.out is None:
            print("next: ffgym log columns FILE --out map.toml writes a draft of a column map")
            return
        print(f"draft: {self.out}")
        print(f"next: fill in every '?', then ffgym log convert {self.log} --columns {self.out} --out recording.npz")
