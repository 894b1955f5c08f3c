"""Machines without OpenGL or without a screen: one clear error, and nothing loaded before it is needed."""

import os
import shutil
import subprocess
import sys
import textwrap

import pytest

from ffgym.envs.rendering.gl import candidates

MAKE = """
import sys
import gymnasium as gym
import ffgym
env = gym.make(gym.spec("ffgym/CirclePath-v0"), render_mode={mode!r}, positions=["p1"], speeds=[0.1])
env.reset(seed=0)
loaded = sorted(name for name in sys.modules if name.split(".")[0] == "OpenGL" or name == "mujoco.viewer")
print("loaded:", loaded[:1])
"""
TRY = """
try:
    {body}
except Exception as error:
    print(type(error).__name__, error)
"""


def python(code, folder, prefix=(), **environment):
    """Output of a Python process with these environment variables; None removes one."""
    settings = dict(os.environ)
    for name in ("MUJOCO_GL", "PYOPENGL_PLATFORM", "DISPLAY", "WAYLAND_DISPLAY"):
        settings.pop(name, None)
    settings |= environment
    done = subprocess.run(
        [*prefix, sys.executable, "-W", "error", "-c", code],
        env=settings, cwd=folder, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert not done.stderr
    assert not list(folder.iterdir())  # MuJoCo writes a log where it stands, if it is let
    return done.stdout


def attempt(mode):
    return TRY.format(body=textwrap.indent(MAKE.format(mode=mode), "    ").strip())


def test_nothing_of_opengl_is_loaded_without_a_render_mode(tmp_path):
    assert python(MAKE.format(mode=None), tmp_path) == "loaded: []\n"


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"MUJOCO_GL": "disable"}, "MUJOCO_GL=disable forbids OpenGL"),
        ({"MUJOCO_GL": "glfw"}, "No OpenGL for pictures (MUJOCO_GL=glfw). glfw: (65550)"),
        ({"MUJOCO_GL": "egl", "PYOPENGL_PLATFORM": "glx"}, "egl: Cannot use EGL rendering platform"),
    ],
)
@pytest.mark.skipif(sys.platform != "linux", reason="names of Linux' OpenGL libraries")
def test_without_opengl_the_error_says_what_failed_and_what_to_install(settings, message, tmp_path):
    (line,) = python(attempt("rgb_array"), tmp_path, **settings).splitlines()
    assert line.startswith("FFGymError")
    assert message in line
    if settings["MUJOCO_GL"] != "disable":
        assert "apt-get install libegl1 libgl1-mesa-dri (or libosmesa6)" in line


@pytest.mark.parametrize("settings", [{}, {"DISPLAY": ":87"}])
@pytest.mark.skipif(sys.platform != "linux", reason="DISPLAY is of Linux")
def test_a_window_without_a_screen_is_one_error_with_the_way_out(settings, tmp_path):
    (line,) = python(attempt("human"), tmp_path, **settings).splitlines()
    assert line.startswith("FFGymError render_mode='human'")
    assert "use render_mode='rgb_array'" in line
    assert "set DISPLAY" in line


def test_a_screen_that_does_not_work_does_not_keep_pictures_from_being_drawn(needs_gl, tmp_path):
    code = MAKE.format(mode="rgb_array") + "print(env.render().shape)"  # never closed: it must end quietly too
    assert "(540, 960, 3)" in python(code, tmp_path, DISPLAY=":87")


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("xvfb-run") is None, reason="needs xvfb-run, a screen in memory")
@pytest.mark.parametrize("end", ["env.close()", ""])
def test_a_window_opens_shows_and_closes(end, needs_gl, tmp_path):
    code = MAKE.format(mode="human") + (
        "for _ in range(30): env.step(env.action_space.sample() * 0)\n"
        f"print(env.render(), env.unwrapped._batch._renderer._window._viewer.is_running())\n{end}"
    )
    assert python(code, tmp_path, prefix=("xvfb-run", "-a")).splitlines()[-1] == "None True"


@pytest.mark.parametrize(
    ("asked", "system", "environment", "expected"),
    [
        ("", "Linux", {}, ["egl", "osmesa"]),
        ("", "Linux", {"DISPLAY": ":0"}, ["glfw", "egl", "osmesa"]),
        ("1", "Linux", {}, ["egl", "osmesa"]),
        ("osmesa", "Linux", {"DISPLAY": ":0"}, ["osmesa"]),
        ("glx", "Linux", {}, ["glfw"]),
        ("", "Darwin", {}, ["cgl", "glfw"]),
        ("", "Windows", {}, ["glfw"]),
        ("wgl", "Windows", {}, ["glfw"]),
    ],
)
def test_mujoco_gl_decides_and_otherwise_what_may_work_is_tried(asked, system, environment, expected):
    assert candidates(asked, system, environment) == expected
