"""Baselines of every comparison: no added torque, and random torque.

Random torque shows how an agent without any knowledge scores: independent torque at every sample, uniform between minus
and plus a share of each joint's breakaway torque.

Run it:

    ffgym leaderboard --agents none random

Logged: nothing; the agents learn nothing.
"""

from dataclasses import dataclass
from typing import final
from zlib import crc32

import numpy as np

from ffgym.agents.declaration import AgentEntry, declare
from ffgym.control import FeedForwardLaw, LawStyle, NoCompensation
from ffgym.core.types import Array
from ffgym.paths import Reference


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RandomTorque(FeedForwardLaw):
    """Random torque, independent of the motion."""

    seed: int
    share: float = 1.0
    """Largest torque in breakaway torques f_s of each joint."""
    name: str = "random"

    def torque(self, reference: Reference) -> Array:
        """Draw the torque; motions of one name get the same one."""
        rng = np.random.default_rng([self.seed, crc32(reference.name.encode())])
        bound = self.share * reference.robot.friction.static
        torque = bound * rng.uniform(-1.0, 1.0, size=reference.q.shape)
        torque[0] = 0.0
        return torque


declare(
    AgentEntry(
        name="none",
        title="no compensation",
        about="No added torque: the servo and the rigid-body feed-forward that every robot has.",
        track="causal",
        order=0,
        page="README.md",
        style=LawStyle(label="no compensation", colour="#0072B2", marker="o"),
        make=lambda setting: NoCompensation(),
    ),
    AgentEntry(
        name="random",
        title="random torque",
        about="Uniform random torque up to breakaway torque: what knowing nothing is worth.",
        track="causal",
        order=1,
        make=lambda setting: RandomTorque(seed=setting.seed),
        seeded=True,
        ranked=False,
        on_commands=False,
    ),
)
