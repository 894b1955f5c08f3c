"""Robots that many tests share."""

import gc
import os
from importlib import resources

import hypothesis
import numpy as np
import pytest
from mujoco import batch

from ffgym.core.errors import FFGymError
from ffgym.envs.rendering.canvas import Canvas
from ffgym.robot import RigidArm, RobotDescription, compile_model, load_robot, solve_path

hypothesis.settings.register_profile("ffgym", deadline=None)  # the first example compiles a model
hypothesis.settings.load_profile("ffgym")


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Look for unused objects neither while tests are collected nor among those that are, which stay to the end."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.fixture(scope="session", autouse=True)
def one_thread_of_the_engine():
    """Give the engine one thread where it is not told how many, and processes of tests share the cores.

    Its threads wait for each other busily, for longer than they compute, if others keep the cores busy.
    """
    begin = batch.Batch.__init__

    def begin_with_one(self, model, nsim, nthread=0, persistent=False):
        begin(self, model, nsim, nthread or 1, persistent)

    with pytest.MonkeyPatch.context() as patch:
        if "PYTEST_XDIST_WORKER" in os.environ:
            patch.setattr(batch.Batch, "__init__", begin_with_one)
        yield


@pytest.fixture(scope="session")
def irb4600() -> RobotDescription:
    """The built-in six-axis robot."""
    return load_robot("irb4600_60_205")


@pytest.fixture(scope="session")
def arm(irb4600: RobotDescription) -> RigidArm:
    """Its rigid dynamics."""
    return RigidArm(irb4600)


@pytest.fixture(scope="session")
def corners(irb4600: RobotDescription, arm: RigidArm) -> dict[str, np.ndarray]:
    """Joint angles [rad], shape (N,), with the TCP at each position of the work area."""
    area = irb4600.work_area
    return {
        name: solve_path(arm, point[None], area.tool_rotation, area.home)[0] for name, point in area.positions.items()
    }


@pytest.fixture(scope="session")
def one_axis() -> RobotDescription:
    """The built-in one-axis model."""
    return load_robot("one_axis")


@pytest.fixture(scope="session")
def two_link() -> RobotDescription:
    """The built-in planar arm of two links."""
    return load_robot("two_link")


@pytest.fixture(scope="session")
def needs_gl(one_axis: RobotDescription) -> None:
    """Skip where no picture can be drawn; fail instead if FFGYM_REQUIRE_GL=1, as on CI."""
    try:
        Canvas(compile_model(one_axis), 64, 64).close()
    except FFGymError as error:
        if os.environ.get("FFGYM_REQUIRE_GL") == "1":
            raise
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def one_axis_text() -> str:
    """Description of the one-axis model as text, to which tests add tables."""
    return (resources.files("ffgym.robot") / "data" / "one_axis.toml").read_text(encoding="utf-8")
