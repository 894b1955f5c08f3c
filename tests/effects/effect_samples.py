"""Effects as strong as they can be, and none."""

import numpy as np

from ffgym.effects import Effect, State

MOTION = (
    "time",
    "joint_angle",
    "joint_speed",
    "bristle",
    "feedback_torque",
    "command",
    "deflection",
    "deflection_rate",
)
"""Variables of a state that do not follow from others."""


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


def state_of(robot, **given):
    """State of a robot at rest and without load but for what is given, (N,) or (..., N) each."""
    shape = np.broadcast_shapes((robot.n_joints,), *(np.shape(value) for value in given.values()))
    state = State.of(robot, **dict.fromkeys(MOTION, 0.0) | given)
    return state.each(lambda value: np.broadcast_to(value, shape) + 0.0)


def torques_at(effect, state):
    """Torques of an effect without memory, or with one that is relaxed."""
    return effect.torques(state, effect.initial_memory(state), 0.00025)[0]
