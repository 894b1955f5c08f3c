"""`ffgym/CirclePath-v0` and `ffgym/WorkcellCircles-v0`: the circle test of the thesis, on robots and on workcells.

It runs at positions of a work area and constant TCP speeds. The controller of a workcell does not have its friction.
"""

from collections.abc import Mapping, Sequence
from itertools import product
from numbers import Real
from pathlib import Path
from typing import Any, Literal

import numpy as np
from gymnasium.vector import AutoresetMode

from ffgym.core.errors import FFGymError, check_choice, check_number, check_shape
from ffgym.core.types import Array
from ffgym.envs.machines import WORKCELL, find_controller
from ffgym.envs.motion import EpisodeMotion
from ffgym.envs.single import TrackingEnv
from ffgym.envs.tasks import Sensing, Tasks, check_not_empty
from ffgym.envs.vector import TrackingVectorEnv
from ffgym.paths import RADII, SPEEDS, cartesian_reference, circle_test
from ffgym.robot import RobotDescription, solve_path

Position = str | Sequence[float] | Array
"""Name of a position of the work area, or a point in the world [m], shape (3,)."""

ORDERS = ("listed", "shuffled", "one")


class CircleTasks(Tasks):
    """Circle tests at several positions and speeds.

    Args:
        robot: nominal one of the controller: description, built-in name, or path to a description ending in .toml;
            it must have a work area.
        positions: names in its work area, or points [m]; None takes all of the area.
        speeds: TCP speeds [m/s].
        radii: circle radii [m].
        order: 'listed' runs all radii as they are listed, as the thesis; 'shuffled' in random order; 'one' one of them.
    """

    option_names = ("position", "speed", "radii", "order")

    def __init__(
        self,
        robot: RobotDescription | str | Path = "irb4600_60_205",
        *,
        positions: Sequence[Position] | None = None,
        speeds: Sequence[float] = SPEEDS,
        radii: Sequence[float] = RADII,
        order: Literal["listed", "shuffled", "one"] = "listed",
    ) -> None:
        super().__init__(robot)
        robot = self.robot
        if robot.work_area is None:
            raise FFGymError(
                f"Robot {robot.name!r} has no work area for circles; use ffgym/OneAxis-v0 for one axis, or "
                f"ffgym/JointMotion-v0."
            )
        self._area = robot.work_area
        chosen = tuple(robot.work_area.positions) if positions is None else _sequence("positions", positions)
        self._positions = check_not_empty("positions", chosen, "'p1'")
        self._speeds = check_not_empty("speeds", _numbers("speeds", speeds), "0.010 m/s")
        self._radii = check_not_empty("radii", _numbers("radii", radii), "0.003 m")
        self._order = check_choice("order", order, ORDERS)
        # refuse now, not in the middle of a training
        for position in self._positions:
            solve_path(self.arm, self._point(position)[1][None], self._area.tool_rotation, self._area.home)
        for radius, speed in product(self._radii, self._speeds):
            circle_test(np.zeros(3), speed, radii=[radius], dt=self.robot.servo.control_dt)

    def draw(self, rng: np.random.Generator, options: Mapping[str, Any]) -> EpisodeMotion:
        """Draw a circle test: position, speed, then the order of the circles."""
        position = options["position"] if "position" in options else _pick(self._positions, rng)
        speed = check_number("speed", options["speed"] if "speed" in options else _pick(self._speeds, rng), unit="m/s")
        radii = check_not_empty("radii", _numbers("radii", options.get("radii", self._radii)), "0.003 m")
        order = check_choice("order", options.get("order", self._order), ORDERS)
        if order == "shuffled":
            radii = tuple(radii[i] for i in rng.permutation(len(radii)))
        elif order == "one":
            radii = (_pick(radii, rng),)
        return self._motion(position, speed, radii)

    def list_options(self) -> list[dict[str, Any]]:
        """List every position at every speed, and with order 'one' every radius."""
        every = [(r,) for r in self._radii] if self._order == "one" else [self._radii]
        return [
            {"position": position, "speed": speed, "radii": radii}
            | ({"order": "listed"} if self._order == "one" else {})
            for speed, position, radii in product(self._speeds, self._positions, every)
        ]

    def _motion(self, position: Position, speed: float, radii: tuple[float, ...]) -> EpisodeMotion:
        label, point = self._point(position)

        def make() -> EpisodeMotion:
            name = f"{label}, {speed * 1e3:g} mm/s"
            normal, dt = self._area.normal, self.robot.servo.control_dt
            path = circle_test(point, speed, radii=radii, normal=normal, dt=dt, name=name)
            task = {"position": label, "speed": speed, "radii": list(radii)}
            return EpisodeMotion(reference=cartesian_reference(self.arm, path), arm=self.arm, task=task)

        return self._keep_motion((label, tuple(point), speed, radii), make)

    def _point(self, position: Position) -> tuple[str, Array]:
        """Label of a position and where it is [m]."""
        if isinstance(position, str):
            return position, self.robot.position(position)
        point = check_shape("position", position, (3,))
        return "({:.4g}, {:.4g}, {:.4g}) m".format(*point), point


def _pick(values: Sequence[Any], rng: np.random.Generator) -> Any:
    return values[int(rng.integers(len(values)))]


def _numbers(name: str, values: Any) -> tuple[float, ...]:
    """Return a sequence of numbers, or one number, as a tuple."""
    return tuple(check_shape(name, np.atleast_1d(values), (None,)).tolist())


def _sequence(name: str, values: Any) -> tuple[Any, ...]:
    """Return a sequence of positions as a tuple; refuse one alone, which would be read as letters or coordinates."""
    if isinstance(values, np.ndarray):
        values = list(np.atleast_1d(values))
    single = isinstance(values, str) or not isinstance(values, Sequence)
    if single or any(isinstance(value, Real) for value in values):
        raise FFGymError(f"{name} = {values!r} must be a list of names or points, e.g. {name}=['p1'].")
    return tuple(values)


class CirclePathVectorEnv(TrackingVectorEnv):
    """Six-axis robots on the circle test.

    Keyword arguments are those of `CircleTasks` and of `ffgym.envs.EnvSettings`.
    """

    tasks = CircleTasks


class CirclePathEnv(TrackingEnv):
    """One six-axis robot on the circle test; keyword arguments as `CirclePathVectorEnv`."""

    kind = CirclePathVectorEnv


_ITS_OWN = ("robot", "plant", "randomization")
"""Arguments of other environments that a workcell sets itself."""


class WorkcellCirclesVectorEnv(CirclePathVectorEnv):
    """Workcells on the circle test; their motor angles are read by resolvers.

    Args:
        num_envs: number of workcells.
        workcell: name, with or without "workcell:", or seed of one that is drawn; or a list of these, of one make of
            controller, one of which is drawn for each episode. Reset option plant, e.g. "workcell:12", changes it
            for an episode.
        autoreset_mode: Gymnasium's NextStep, SameStep or Disabled.
        render_mode: 'rgb_array' or None.
        arguments: others of `CirclePathVectorEnv`, but for robot, plant and randomization.
    """

    def __init__(
        self,
        num_envs: int = 1,
        *,
        workcell: str | int | Sequence[str | int] = "thesis",
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        **arguments: Any,
    ) -> None:
        for name in _ITS_OWN:
            if name in arguments:
                raise FFGymError(
                    f"{name} = {arguments[name]!r} cannot be given: a workcell has fixed parameters. Choose another by "
                    f"workcell=<name or seed>, or use ffgym/CirclePath-v0."
                )
        listed = workcell if isinstance(workcell, Sequence) and not isinstance(workcell, str) else [workcell]
        plants = [WORKCELL + str(one).removeprefix(WORKCELL) for one in listed]
        controllers = sorted({find_controller(plant) for plant in plants})
        if len(controllers) != 1:
            raise FFGymError(
                f"workcell = {workcell!r} must be workcells of one controller, at least one; those have {controllers}."
            )
        super().__init__(
            num_envs,
            robot=controllers[0],
            plant=plants if len(plants) > 1 else plants[0],
            autoreset_mode=autoreset_mode,
            render_mode=render_mode,
            **({"sensing": Sensing(encoder_bits=16)} | arguments),
        )


class WorkcellCirclesEnv(TrackingEnv):
    """One workcell on the circle test; keyword arguments as `WorkcellCirclesVectorEnv`."""

    kind = WorkcellCirclesVectorEnv
