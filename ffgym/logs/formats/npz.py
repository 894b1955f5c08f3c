"""NPZ files of other tools: arrays as they are; a time series of MuJoCo's system identification is split by signal."""

import json

from ffgym.core.errors import FFGymError
from ffgym.core.files import decode_arrays
from ffgym.logs.contents import Contents
from ffgym.logs.log_format import LogFormat

TIME_SERIES = frozenset({"times", "data", "signal_mapping"})
"""Arrays that `mujoco.sysid.TimeSeries.save_to_disk` writes: data (T, K), and JSON of signal -> [kind, columns]."""


class Npz(LogFormat):
    """Arrays by name; Python objects are refused."""

    title = "an NPZ file"
    suffixes = (".npz",)

    def decode(self, data: bytes, where: str) -> Contents:
        """Read the arrays of an NPZ archive."""
        arrays = decode_arrays(data)
        if set(arrays) != TIME_SERIES:
            return Contents(where=where, arrays=arrays)
        table, signals = arrays["data"], {}
        try:
            for name, (_, columns) in json.loads(str(arrays["signal_mapping"])).items():
                signals[name] = table[:, columns[0]] if len(columns) == 1 else table[:, columns]
        except (ValueError, TypeError, AttributeError, IndexError, RecursionError) as error:
            raise FFGymError(f"signal_mapping does not fit data {table.shape}: {error}.") from error
        return Contents(where=where, arrays=arrays | signals)
