"""`ffgym/WorkcellCircles-v0`: the circle test on a workcell, whose friction nobody told its controller."""

from typing import Any

from gymnasium.vector import AutoresetMode

from ffgym.core.errors import FFGymError
from ffgym.envs.circle_path import CirclePathVectorEnv
from ffgym.envs.machines import WORKCELL
from ffgym.envs.single import TrackingEnv
from ffgym.envs.tasks import Sensing

CONTROLLER = "irb4600_60_205_commissioned"
"""What the controller of every workcell knows."""

_ITS_OWN = ("robot", "plant", "randomization")
"""Arguments of other environments that a workcell answers itself."""


class WorkcellCirclesVectorEnv(CirclePathVectorEnv):
    """Workcells on the circle test; their motor angles are read by resolvers.

    Args:
        num_envs: number of workcells.
        workcell: name, with or without "workcell:", or seed of one that is drawn; reset option plant, e.g.
            "workcell:12", changes it for an episode.
        autoreset_mode: Gymnasium's NextStep, SameStep or Disabled.
        render_mode: 'rgb_array' or None.
        arguments: others of `CirclePathVectorEnv`, but for robot, plant and randomization.
    """

    def __init__(
        self,
        num_envs: int = 1,
        *,
        workcell: str | int = "thesis",
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        **arguments: Any,
    ) -> None:
        for name in _ITS_OWN:
            if name in arguments:
                raise FFGymError(
                    f"{name} = {arguments[name]!r} cannot be given, a workcell is what it is. Choose another by "
                    f"workcell=<name or seed>, or use ffgym/CirclePath-v0."
                )
        super().__init__(
            num_envs,
            robot=CONTROLLER,
            plant=WORKCELL + str(workcell).removeprefix(WORKCELL),
            autoreset_mode=autoreset_mode,
            render_mode=render_mode,
            **({"sensing": Sensing(encoder_bits=16)} | arguments),
        )


class WorkcellCirclesEnv(TrackingEnv):
    """One workcell on the circle test; keyword arguments as `WorkcellCirclesVectorEnv`."""

    kind = WorkcellCirclesVectorEnv
