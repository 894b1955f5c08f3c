"""An OpenGL context without a window, from whatever this machine has."""

import os
import platform
import sys
import warnings
from collections.abc import Mapping
from importlib import import_module
from typing import Any

from ffgym.errors import FFGymError

_ANY = ("", "enable", "enabled", "on", "true", "1")
_OFF = ("disable", "disabled", "off", "false", "0")
_HELP = (
    "On Debian or Ubuntu, apt-get install libegl1 libgl1-mesa-dri (or libosmesa6), and leave MUJOCO_GL unset or set it "
    "to egl (or osmesa) before Python starts"
)


def open_context(width: int, height: int) -> Any:
    """Context of MuJoCo's `GLContext` kind for pictures up to that size; it is current afterwards.

    MUJOCO_GL decides which library makes it; where it is not set, the first that works does.

    Raises:
        FFGymError: if none works.
    """
    asked = os.environ.get("MUJOCO_GL", "").strip().lower()
    if asked in _OFF:
        raise FFGymError(f"MUJOCO_GL={asked} forbids OpenGL, so that nothing can be rendered; unset it.")
    failures = []
    for backend in candidates(asked, platform.system(), os.environ):
        try:
            return _open(backend, width, height)
        except Exception as error:  # each library fails in its own ways, from ImportError to ctypes' AttributeError
            failures.append(f"{backend}: {' '.join(str(error).split()) or type(error).__name__}")
    setting = f"MUJOCO_GL={asked}" if asked else "MUJOCO_GL is not set"
    raise FFGymError(f"No OpenGL for pictures ({setting}). {'; '.join(failures)}. {_HELP}.")


def candidates(asked: str, system: str, environment: Mapping[str, str]) -> list[str]:
    """Names of MuJoCo's context modules to try, in order, for a value of MUJOCO_GL."""
    if asked not in _ANY:
        return ["glfw" if asked in ("glx", "wgl") else asked]
    if system == "Darwin":
        return ["cgl", "glfw"]
    if system != "Linux":
        return ["glfw"]
    return ["glfw", "egl", "osmesa"] if has_display(environment) else ["egl", "osmesa"]


def has_display(environment: Mapping[str, str]) -> bool:
    """Whether a Linux session has a screen."""
    return bool(environment.get("DISPLAY") or environment.get("WAYLAND_DISPLAY"))


def _open(backend: str, width: int, height: int) -> Any:
    """Open a context; if that fails, leave no trace that would keep the next backend from working.

    PyOpenGL binds itself to one platform when it is first imported, and MuJoCo chooses that through PYOPENGL_PLATFORM.
    """
    before, chosen = set(sys.modules), os.environ.get("PYOPENGL_PLATFORM")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # GLFW only warns when it fails
            warnings.simplefilter("ignore", DeprecationWarning)
            context = import_module(f"mujoco.{backend}").GLContext(width, height)
            context.make_current()
            return context
    except Exception:
        for name in set(sys.modules) - before:
            if name.split(".")[0] == "OpenGL" or name.startswith(f"mujoco.{backend}"):
                del sys.modules[name]
        raise
    finally:
        if chosen is None:  # child processes choose for themselves
            os.environ.pop("PYOPENGL_PLATFORM", None)
