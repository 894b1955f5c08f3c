"""`ffgym/FollowPath-v0`: any motion, from a name, a file or a reference, on any robot."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.envs.motion import EpisodeMotion
from ffgym.envs.single import TrackingEnv
from ffgym.envs.tasks import Tasks, check_not_empty
from ffgym.envs.vector import TrackingVectorEnv
from ffgym.paths import Reference
from ffgym.paths.motions import load_motion
from ffgym.robot import ModelOptions, RigidArm, RobotDescription, compile_model, physics_fingerprint, robot_of

Source = str | Path | Reference
"""Name of a built-in motion, path to a file that `ffgym.paths.motions.load_motion` reads, or a reference."""

ROBOT = "irb4600_60_205"
"""Robot if neither a robot nor a reference, which has one, is given."""


class PathTasks(Tasks):
    """Motions that were made before; each episode follows one of them.

    Args:
        robot: nominal one of the controller: description, built-in name, or path to a description ending in .toml;
            None takes that of the first reference among `path`, or the built-in six-axis robot.
        path: name of a built-in motion, file of a motion, `Reference`, or a list of these, one of which is drawn for
            each episode. A file may bring its own tool, which then is the robot's.
    """

    option_names = ("path",)

    def __init__(
        self, robot: RobotDescription | str | Path | None = None, *, path: Source | Sequence[Source] = "circles"
    ) -> None:
        sources = check_not_empty("path", _sources(path), "'circles'")
        given = [source.robot for source in sources if isinstance(source, Reference)]
        arm = RigidArm(robot_of(robot if robot is not None else given[0] if given else ROBOT))
        references = [_reference(arm, source) for source in sources]
        super().__init__(references[0].robot)
        self._plain = arm
        """Model of the robot as it was given, for files of motions."""
        self._fingerprint = _fingerprint(self.robot)
        self._sources = sources
        for source, reference in zip(sources, references, strict=True):
            self._make_motion(source, reference)  # refuse now, not in the middle of a training

    def draw(self, rng: np.random.Generator, options: Mapping[str, Any]) -> EpisodeMotion:
        """Draw one of the motions; the option `path` may be any motion that the keyword takes."""
        if "path" in options:
            sources = _sources(options["path"])
            if len(sources) != 1:
                raise FFGymError(f"path = {options['path']!r} must be one motion: an episode follows one.")
            return self._make_motion(sources[0])
        return self._make_motion(self._sources[int(rng.integers(len(self._sources)))])

    def list_options(self) -> list[dict[str, Any]]:
        """List every motion."""
        return [{"path": source} for source in self._sources]

    def _make_motion(self, source: Source, reference: Reference | None = None) -> EpisodeMotion:
        def make() -> EpisodeMotion:
            made = _reference(self._plain, source) if reference is None else reference
            if made.robot is not self.robot and _fingerprint(made.robot) != self._fingerprint:
                raise FFGymError(
                    f"Motion {made.name!r} is for robot {made.robot.name!r} with other numbers (perhaps another tool) "
                    f"than those of this environment's robot {self.robot.name!r}; make it for that robot, or make an "
                    f"environment of its own."
                )
            task = {"path": made.name if isinstance(source, Reference) else str(source)}
            return EpisodeMotion(reference=made, arm=self.arm, task=task, in_space=True)

        return self._keep_motion(id(source) if isinstance(source, Reference) else str(source), make)


def _sources(path: Any) -> tuple[Source, ...]:
    """Return one motion, or a sequence of them, as a tuple."""
    listed = path if isinstance(path, list | tuple) else [path]
    for source in listed:
        if not isinstance(source, str | Path | Reference):
            raise FFGymError(
                f"path = {source!r} must be the name of a motion, a path to a file, a Reference, or a list of these."
            )
    return tuple(listed)


def _reference(arm: RigidArm, source: Source) -> Reference:
    return source if isinstance(source, Reference) else load_motion(arm, source).reference


def _fingerprint(robot: RobotDescription) -> str:
    return physics_fingerprint(compile_model(robot, ModelOptions(looks=False)))


class FollowPathVectorEnv(TrackingVectorEnv):
    """Robots of any kind on motions of any kind.

    Keyword arguments are those of `PathTasks` and of `ffgym.envs.EnvSettings`.
    """

    tasks = PathTasks


class FollowPathEnv(TrackingEnv):
    """One robot on motions of any kind; keyword arguments as `FollowPathVectorEnv`."""

    kind = FollowPathVectorEnv
