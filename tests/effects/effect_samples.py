"""Effects as strong as they can be, and none."""

import numpy as np

from ffgym.effects import Effect


def as_strong_as_plausible(effect: type[Effect], robot, share=1.0):
    """The effect with every parameter at that end of its range which is farther from nothing, or a share of the way."""
    values = {}
    for name, known in effect.parameters().items():
        far = max((known.low, known.high), key=lambda x: abs(x - known.neutral))
        far = known.neutral + share * (far - known.neutral)
        values[name] = far if known.null is not None else known.high
        if known.per == "pair":
            values[name] = far * (1 - np.eye(robot.n_joints))
    return effect.on(robot, **values)


def without_effect(effect: type[Effect], robot):
    """The effect with every parameter at its null value."""
    values = {name: known.neutral for name, known in effect.parameters().items()}
    return effect.on(robot, **values)
