"""Provenance of a result: versions of program, libraries and interpreter."""

import platform
from importlib import metadata

from ffgym.core.version import __version__


def versions() -> dict[str, str]:
    """Return versions of all programs that can change a number."""
    libraries = {name: metadata.version(name) for name in ("mujoco", "numpy", "scipy", "gymnasium")}
    return {"ffgym": __version__, **libraries, "python": platform.python_version()}


def is_installed(package: str) -> bool:
    """Check if a distribution of that name is installed, without importing it."""
    try:
        metadata.version(package)
    except metadata.PackageNotFoundError:
        return False
    return True
