"""Published recordings of real machines: they are not part of the package, and lie where FFGYM_DATA says."""

import os
from pathlib import Path

from ffgym.core.errors import FFGymError

DATA_VARIABLE = "FFGYM_DATA"
"""Environment variable with the folder of published recordings."""


def measured_folder() -> Path:
    """Folder of published recordings, which `ffgym.logs.read_log` reads with the column map of each.

    Raises:
        FFGymError: if the environment variable is not set, or leads to no folder.
    """
    folder = os.environ.get(DATA_VARIABLE, "")
    if not folder or not Path(folder).is_dir():
        raise FFGymError(f"{DATA_VARIABLE} = {folder!r} must be the folder with the published recordings.")
    return Path(folder)
