"""Where a result comes from: program and library versions, interpreter, seed."""

import platform
from importlib import metadata

import gymnasium
import mujoco
import numpy as np
import scipy

from ffgym.core.version import __version__


def versions() -> dict[str, str]:
    """Versions of everything that can change a number."""
    return {
        "ffgym": __version__,
        "mujoco": mujoco.__version__,
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "gymnasium": gymnasium.__version__,
        "python": platform.python_version(),
    }


def installed(package: str) -> bool:
    """Whether a distribution of that name is installed, without importing it."""
    try:
        metadata.version(package)
    except metadata.PackageNotFoundError:
        return False
    return True
