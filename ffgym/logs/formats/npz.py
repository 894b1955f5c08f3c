"""NPZ files of other tools: arrays as they are; a time series of MuJoCo's system identification is split by signal."""

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError
from ffgym.core.files import decode_arrays
from ffgym.logs.contents import Contents
from ffgym.logs.log_format import LogFormat

TIME_SERIES = frozenset({"times", "data", "signal_mapping"})
"""Arrays that `mujoco.sysid.TimeSeries.save_to_disk` writes: data (T, K), and which columns each signal has."""


class Npz(LogFormat):
    """Arrays by name; Python objects are refused."""

    title = "an NPZ file"
    suffixes = (".npz",)

    def decode(self, data: bytes, where: str) -> Contents:
        """See base class."""
        arrays = decode_arrays(data)
        if set(arrays) == TIME_SERIES:
            arrays |= _signals(arrays)
        return Contents(where=where, arrays=arrays)


def _signals(arrays: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Columns (T, width) of `data` by the names in `signal_mapping`, JSON of name -> [kind, columns]."""
    try:
        mapping = json.loads(str(arrays["signal_mapping"]))
        return {
            name: np.squeeze(arrays["data"][:, columns], axis=1) if len(columns) == 1 else arrays["data"][:, columns]
            for name, (_, columns) in mapping.items()
        }
    except (ValueError, TypeError, AttributeError, IndexError, RecursionError) as error:
        raise FFGymError(f"signal_mapping does not fit data {arrays['data'].shape}: {error}.") from error
