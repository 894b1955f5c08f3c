"""Machines to train on: drawn around a nominal robot, with effects of the library; no workcells."""

from typing import Any

import numpy as np

from ffgym.effects import Effect
from ffgym.effects.drive.ripple import TorqueRipple
from ffgym.effects.friction.asymmetry import Asymmetry
from ffgym.effects.friction.falling import FallingFriction
from ffgym.effects.friction.load import LoadFriction
from ffgym.effects.measurement.resolver_error import ResolverRipple
from ffgym.effects.transmission.hysteresis import TorsionalHysteresis
from ffgym.effects.transmission.kinematic_error import KinematicError
from ffgym.robot import RobotDescription
from ffgym.simulation.plant import LogUniform, Machine, PlantDistribution, Uniform

WIDE = PlantDistribution(
    friction_level=LogUniform(0.5, 2.0),
    viscous=LogUniform(0.4, 2.5),
    stribeck_velocity=LogUniform(0.7, 1.4),
    bristle_stiffness=LogUniform(0.4, 2.0),
    bristle_damping=LogUniform(0.5, 2.0),
    joint_stiffness=LogUniform(0.5, 2.0),
    link_inertia=LogUniform(0.8, 1.25),
    rotor_inertia=LogUniform(0.8, 1.25),
    arm_share=Uniform(0.1, 0.95),
    torque_lag=LogUniform(0.5, 2.0),
    torque_delay=LogUniform(0.5, 2.0),
    torque_rate=LogUniform(0.5, 2.0),
    payload=Uniform(0.0, 12.0),
)
"""Distribution of the robot's numbers. Chosen: half to double of friction and stiffness, a quarter of masses, any share
of friction on the arm, as one who knows no machine but the data sheet would; wider than the defaults, since numbers
beyond the draws are numbers that the estimator never learned."""
PRESENT = 0.5
"""Probability that a machine has an effect; chosen."""


def draw_machine(nominal: RobotDescription, rng: np.random.Generator) -> Machine:
    """Draw a machine around a nominal robot with drives that are not ideal and friction behind the elasticity.

    Sizes of effects are uniform up to some of those that `ffgym.effects` gives as known. Those that an estimator does
    not estimate (errors of gears and resolvers, ripple) teach it what to take for noise.
    """
    robot, n = WIDE.draw(nominal, rng), nominal.n_joints

    def wave(*cycles: int) -> dict[str, Any]:
        return {"cycles": float(rng.choice(cycles)), "phase": rng.uniform(-np.pi, np.pi, n)}

    # every draw is made, so that one effect does not shift the draws of the next
    effects: list[Effect] = [
        Asymmetry.on(robot, coulomb=rng.uniform(-0.2, 0.2, n), viscous=0.0),
        LoadFriction.on(robot, share=rng.uniform(0.0, 0.06, n)),
        FallingFriction.on(
            robot,
            share=rng.uniform(0.0, 0.3, n),
            width=np.exp(rng.uniform(np.log(3.0), np.log(30.0))),
            exponent=1.0,
        ),
        TorsionalHysteresis.on(
            robot,
            lost_motion=rng.uniform(0.0, 4e-5, n),
            width=np.exp(rng.uniform(np.log(1e-4), np.log(6e-4))),
        ),
    ]
    effects += [
        KinematicError.on(robot, amplitude=rng.uniform(0.0, 3e-5, n), **wave(1, 2, 3)),
        TorqueRipple.on(robot, share=rng.uniform(0.0, 0.03, n), **wave(1, 2, 3, 6)),
        ResolverRipple.on(robot, amplitude=rng.uniform(0.0, 1.5e-3, n), **wave(1, 2)),
    ]
    present = rng.random(len(effects)) < PRESENT
    return Machine(robot=robot, effects=tuple(e for e, there in zip(effects, present, strict=True) if there))


def draw_machines(nominal: RobotDescription, count: int, seed: int) -> list[Machine]:
    """Draw machines one after the other, so that a seed means the same ones at any count; see `draw_machine`."""
    rng = np.random.default_rng(seed)
    return [draw_machine(nominal, rng) for _ in range(count)]
