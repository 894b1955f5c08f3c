"""Settings that all environments share, beside their motions."""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, cast, overload

import numpy as np

from ffgym.control import FeedForwardLaw
from ffgym.control.observation import CHANNELS, Channel, size_actions
from ffgym.core.errors import FFGymError, check_choice, check_number, check_shape, check_whole
from ffgym.core.types import Array
from ffgym.envs.recorder import EpisodeRecorder
from ffgym.envs.rendering import Rendering
from ffgym.envs.rewards import Reward, find_reward
from ffgym.envs.tasks import Sensing
from ffgym.robot import RobotDescription
from ffgym.simulation.plant import Machine, PlantDistribution

if TYPE_CHECKING:
    from ffgym.envs.layers import Layer

ACTION_SCALE = 2.5
"""Torque of an action of 1, in breakaway torques. Static LuGre needs 2.4 on the fastest test motion; the peaks of
dynamic LuGre need 2.9 on circles at 40 mm/s and 6.7 at 100 mm/s, so choose 8 there. Elastic feed-forward, which moves
the motors against their servos, needs 7.2 and 102."""
SENSINGS = {"exact": Sensing(), "resolver": Sensing(encoder_bits=16)}
"""Sensing by name."""
TRACKS = ("feedback", "feed-forward")
"""Tracks: whether an agent sees the present error of the motors."""
PlantName = Machine | RobotDescription | str | Path
"""A machine, a description, or the name of one."""
ERROR_LIMIT = 0.5
"""Servo error at which the controller stops, motor side [rad]; four times the largest uncompensated error of the circle
test (0.11 rad, joint 1 at 100 mm/s)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class EnvSettings:
    """Keyword arguments of every environment."""

    plant: PlantName | Sequence[PlantName] | None = None
    """Simulated robot if it is not the nominal one of the controller: a description, a built-in name, a path to a
    description that ends in .toml, or a machine with physical effects of its own; or a list of these, one of which is
    drawn for each episode."""
    randomization: PlantDistribution | None = None
    """Distribution of plants around `plant`, drawn for every episode; None always simulates `plant` itself."""
    reward: str | Reward = "motor_error"
    """'motor_error', 'path_error' (privileged), 'feedback_effort', or a Reward with its own weights."""
    action_scale: float | Sequence[float] = ACTION_SCALE
    """Added torque of an action of 1, in units of each joint's breakaway torque f_s; one number, or one per joint.
    `bound` is another name of it."""
    base: str | FeedForwardLaw = "none"
    """Law whose torque is added beside the action, however large: 'none', 'lugre_static', 'lugre_dynamic', 'elastic',
    'model:machine.toml', made for the robot of the controller, or a law."""
    channel: Channel = "torque"
    """'torque' adds action and base to the torque of each motor, 'setpoint' to the position that its servo follows: an
    action of 1 is `action_scale` times f_s / K_p then, and the base is what makes the servo give its torque."""
    track: Literal["feedback", "feed-forward"] = "feedback"
    """'feedback' observes the motors' errors, 'feed-forward' the reference and what is added alone."""
    features: bool = False
    """True observes directions of motion and the torque of the base, too; errors then count in tenths."""
    preview: int = 1
    """Samples of the reference after the present one that are observed."""
    horizon: int | None = None
    """Longest episode [control steps]; None runs to the end of the motion."""
    error_limit: float = ERROR_LIMIT
    """Position error of any motor at which the controller stops the robot, motor side [rad]."""
    sensing: Sensing | str = field(default_factory=Sensing)
    """Measurement of the motor angle that the agent observes."""
    sampling: Literal["random", "sequence"] = "random"
    """'random' draws the motion of each episode; 'sequence' runs all motions of the task one after the other: the k-th
    episode of sub-environment i is motion i + k B. To meet each of them equally often, B must divide their number."""
    layers: Sequence["Layer"] = ()
    """Layers between agent and robot, from the robot outwards: ResidualAction, History, LowPassAction, Hold, ..."""
    rendering: Rendering = field(default_factory=Rendering)
    """Size of pictures, and magnification of the error."""
    recorder: EpisodeRecorder | None = None
    """Recorder that turns every finished episode into a Recording."""
    n_threads: int = 0
    """Threads of the engine, 0 for all cores; results are the same at any number."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "reward", find_reward(self.reward))
        if not isinstance(self.layers, Sequence) or isinstance(self.layers, str):
            raise FFGymError(
                f"layers = {self.layers!r} must be a list, from the robot outwards, e.g. layers=[History(8)]."
            )
        object.__setattr__(self, "layers", tuple(self.layers))
        limit = check_number("error_limit", self.error_limit, unit="rad", low=0.0, open_low=True)
        object.__setattr__(self, "error_limit", limit)
        check_choice("sampling", self.sampling, ("random", "sequence"))
        check_choice("track", self.track, TRACKS)
        check_choice("channel", self.channel, CHANNELS)
        if not isinstance(self.features, bool):
            raise FFGymError(f"features = {self.features!r} must be True or False.")
        check_horizon(self.horizon)
        object.__setattr__(self, "sensing", find_sensing(self.sensing))
        for name in _KINDS:
            check_kind(name, getattr(self, name))

    @classmethod
    def of(cls, values: dict[str, Any], own: Sequence[str]) -> "EnvSettings":
        """Build settings from the keyword arguments that are left when an environment has taken its `own`.

        Raises:
            FFGymError: if one is unknown.
        """
        known = [*own, *(f.name for f in fields(cls)), "bound"]
        for name in values:
            check_choice("keyword argument", name, known)
        if "bound" in values:  # which an id may set, so that it gives way to the older name
            values = {"action_scale": values["bound"]} | values
            del values["bound"]
        return cls(**values)

    def action_size(self, robot: RobotDescription) -> Array:
        """Compute what an action of 1 adds, motor side: torque [N m], or position of the set-point [rad], shape (N,).

        Raises:
            FFGymError: if the scale does not fit the robot, or its servo does not take corrections of set-points.
        """
        n = robot.n_joints
        scale = np.full(n, self.action_scale) if np.ndim(self.action_scale) == 0 else self.action_scale
        scale = check_shape("action_scale", scale, (n,))
        if np.any(scale <= 0):
            raise FFGymError(f"action_scale = {self.action_scale} must be > 0 on every joint.")
        return size_actions(robot, scale, self.channel)


_KINDS: dict[str, tuple[type, bool, str]] = {
    "randomization": (PlantDistribution, True, "PlantDistribution()"),
    "sensing": (Sensing, False, "Sensing(encoder_bits=16)"),
    "rendering": (Rendering, False, "Rendering(magnify=20)"),
    "recorder": (EpisodeRecorder, True, "EpisodeRecorder()"),
}
"""Class of an argument, True if it may be None, and an example."""


def find_sensing(sensing: Sensing | str) -> Sensing:
    """Return sensing as it is, or by its name: 'exact', or 'resolver' for that of the built-in robots, 16 bits."""
    if isinstance(sensing, str):
        return SENSINGS[check_choice("sensing", sensing, list(SENSINGS))]
    return cast(Sensing, check_kind("sensing", sensing))


def check_kind(name: str, value: Any) -> Any:
    """Return the value of an argument if it is of its kind, by `_KINDS`."""
    kind, may_be_none, example = _KINDS[name]
    if isinstance(value, kind) or (value is None and may_be_none):
        return value
    also = " or None" if may_be_none else ""
    raise FFGymError(f"{name} = {value!r} must be of class {kind.__name__}, e.g. {example}{also}.")


@overload
def check_horizon(horizon: int) -> int: ...
@overload
def check_horizon(horizon: None) -> None: ...
def check_horizon(horizon: int | None) -> int | None:
    """Return a horizon [control steps] if it is None or at least one step."""
    return None if horizon is None else check_whole("horizon", horizon, unit="control steps", low=1, high=2**53)
