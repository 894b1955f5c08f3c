"""OpenGL context without a window, by the first library that works on this machine."""

import os
import platform
import sys
import warnings
from collections.abc import Mapping
from importlib import import_module
from typing import Any

import mujoco

from ffgym.core.errors import FFGymError

_ANY = ("", "enable", "enabled", "on", "true", "1")
_OFF = ("disable", "disabled", "off", "false", "0")
_HELP = (
    "On Debian or Ubuntu, apt-get install libegl1 libgl1-mesa-dri (or libosmesa6), and leave MUJOCO_GL unset or set it "
    "to egl (or osmesa) before Python starts"
)


def open_context(model: mujoco.MjModel, width: int, height: int, font: mujoco.mjtFontScale) -> tuple[Any, Any]:
    """Open a context of MuJoCo's `GLContext` kind for pictures of that size, and the `MjrContext` in it.

    MUJOCO_GL decides which library makes it; where it is not set, the first that works does.
    """
    asked = os.environ.get("MUJOCO_GL", "").strip().lower()
    if asked in _OFF:
        raise FFGymError(f"MUJOCO_GL={asked} forbids OpenGL, so that nothing can be rendered; unset it.")
    failures = []
    for backend in candidates(asked, platform.system(), os.environ):
        try:
            return _open(backend, model, width, height, font)
        except Exception as error:  # each library fails in its own ways
            reason = " ".join(str(error).split()).rstrip(".") or type(error).__name__
            if isinstance(error, AttributeError):  # PyOpenGL did not find the library and calls a function of None
                reason = "its library cannot be loaded"
            failures.append(f"{backend}: {reason}")
    setting = f"MUJOCO_GL={asked}" if asked else "MUJOCO_GL is not set"
    raise FFGymError(f"No OpenGL for pictures ({setting}). {'; '.join(failures)}. {_HELP}.")


def candidates(asked: str, system: str, environment: Mapping[str, str]) -> list[str]:
    """List the names of MuJoCo's context modules to try, in order, for a value of MUJOCO_GL."""
    if asked not in _ANY:
        return ["glfw" if asked in ("glx", "wgl") else asked]
    if system == "Darwin":
        return ["cgl", "glfw"]
    if system != "Linux":
        return ["glfw"]
    return ["glfw", "egl", "osmesa"] if has_display(environment) else ["egl", "osmesa"]


def has_display(environment: Mapping[str, str]) -> bool:
    """Check if a Linux session has a screen."""
    return bool(environment.get("DISPLAY") or environment.get("WAYLAND_DISPLAY"))


def start_glfw() -> None:
    """Start GLFW, which opens windows."""
    import glfw

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        works = glfw.init()
    if not works:
        raise ImportError("; ".join(str(warning.message) for warning in caught) or "GLFW does not start")


def _open(
    backend: str, model: mujoco.MjModel, width: int, height: int, font: mujoco.mjtFontScale
) -> tuple[Any, mujoco.MjrContext]:
    """Open a context; if that fails, leave no trace that would keep the next backend from working.

    PyOpenGL binds itself to one platform when it is first imported, and MuJoCo chooses that through PYOPENGL_PLATFORM.
    MuJoCo's own library reads MUJOCO_GL when the first `MjrContext` is made.
    """
    before = set(sys.modules)
    outside = {name: os.environ.get(name) for name in ("PYOPENGL_PLATFORM", "MUJOCO_GL")}
    os.environ["MUJOCO_GL"] = backend
    try:
        if backend == "glfw":
            start_glfw()
        context = import_module(f"mujoco.{backend}").GLContext(width, height)
        with context.as_current():  # and not longer, so that any thread may draw
            return context, mujoco.MjrContext(model, font.value)
    except Exception:
        for name in set(sys.modules) - before:
            if name.split(".")[0] == "OpenGL" or name.startswith(f"mujoco.{backend}"):
                del sys.modules[name]
        raise
    finally:
        for name, value in outside.items():  # child processes choose for themselves
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
