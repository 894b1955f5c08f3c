"""Where a result comes from: program and library versions, interpreter, seed."""

import platform
from importlib import metadata

from ffgym.core.version import __version__


def versions() -> dict[str, str]:
    """Versions of everything that can change a number."""
    libraries = {name: metadata.version(name) for name in ("mujoco", "numpy", "scipy", "gymnasium")}
    return {"ffgym": __version__, **libraries, "python": platform.python_version()}


def installed(package: str) -> bool:
    """Whether a distribution of that name is installed, without importing it."""
    try:
        metadata.version(package)
    except metadata.PackageNotFoundError:
        return False
    return True
