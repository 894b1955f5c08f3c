"""Requirement on residual policies: gain and delay that their loop must bear on a robot and on machines around it.

Path errors do not show what feedback costs: gains that are tuned by them alone grow until the motors chatter within
the bound of the residual. See `ffgym.leaderboard.evaluation.margins` for the criterion.
"""

from collections.abc import Sequence

import numpy as np

from ffgym.agents.amortised.draws import draw_machines
from ffgym.agents.residual.gains import make_gains
from ffgym.agents.residual.plan import ENCODER_BITS, ENVIRONMENT
from ffgym.agents.residual.policy import ResidualPolicy
from ffgym.agents.residual.validation import SEED
from ffgym.core.errors import check_number, check_whole
from ffgym.envs import Sensing
from ffgym.leaderboard.evaluation.margins import CIRCLES, Change, LoopMargins, find_stable
from ffgym.leaderboard.plants import TestPlant
from ffgym.leaderboard.tasks import Task
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import SimulatedRig

QUICK_CIRCLES = CIRCLES[1:]
"""Circles on which a search checks its candidates: those that take a second."""


def plants_around(robot: str, draws: int, seed: int = SEED) -> list[TestPlant]:
    """Make the nominal robot and machines drawn around it, under the controller of the nominal one.

    Args:
        robot: name of the nominal robot; for draws one with drives and losses.
        draws: number of machines with physical effects, see `ffgym.agents.amortised.draws`.
        seed: seed of these machines.
    """
    arm = RigidArm(load_robot(robot))
    arguments = {"robot": robot, "sensing": Sensing(encoder_bits=ENCODER_BITS)}
    nominal = TestPlant(name=robot, rig=SimulatedRig(arm=arm), env_id=ENVIRONMENT, env_arguments=arguments)
    drawn = [
        TestPlant(
            name=f"{robot}, draw {i}",
            rig=SimulatedRig(arm=arm, machine=machine),
            env_id=ENVIRONMENT,
            env_arguments={**arguments, "plant": machine},
        )
        for i, machine in enumerate(draw_machines(arm.robot, draws, seed))
    ]
    return [nominal, *drawn]


def has_margins(
    policy: ResidualPolicy,
    required: LoopMargins,
    plants: Sequence[TestPlant],
    *,
    circles: Sequence[Task] = QUICK_CIRCLES,
    n_threads: int = 0,
) -> bool:
    """Check that the loop of a policy is stable with a larger gain, and with a delay, each by itself, on all machines.

    Args:
        policy: policy on a causal law.
        required: smallest margins; a delay of None asks for none, as 0 does.
        plants: machines; those behind the first that is unstable do not run.
        circles: motions, of one circle each.
        n_threads: threads of the engine, 0 for all cores.

    Raises:
        FFGymError: if the required gain is below 1, or the delay is negative.
    """
    changes = [*_factors_up_to(required), *_delays_up_to(required)]
    silent = make_gains((0.0, 0.0, 0.0), n_motors=policy.actor.n_motors, base=policy.base)
    return all(
        find_stable(plant, policy, silent, changes, circles=circles, n_threads=n_threads).all() for plant in plants
    )


def _factors_up_to(required: LoopMargins) -> list[Change]:
    """List factors from 1 to the required one, in steps of at most 19 %, as a loop may lock beyond its margin."""
    gain = check_number("required gain margin", required.gain, low=1.0)
    steps = int(np.ceil(4 * np.log2(gain) - 1e-9))
    return [Change(factor=float(factor)) for factor in np.geomspace(1.0, gain, steps + 1)]


def _delays_up_to(required: LoopMargins) -> list[Change]:
    """List delays from 1 sample to the required one."""
    delay = check_whole("required delay margin", required.delay or 0, unit="samples", low=0)
    return [Change(delay=k) for k in range(1, delay + 1)]
