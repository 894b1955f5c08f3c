r"""Residual policies: reinforcement learning on top of a feed-forward law with nominal parameters.

Idea: a law made from nominal parameters leaves an error because the machine differs from them. A small network sees
that error, its own last torques, and the reference ahead, and adds a bounded torque; with f_s the breakaway torque,

.. math:: u_{lff} = u_{base} + \beta f_s r(x), \qquad r \in [-1, 1]^N, \quad r = 0 \text{ before training}

It is trained on robots drawn around the nominal one, so that it learns to adapt to what it observes, not one machine.

Source: residual policy learning (Silver et al. 2018, arXiv:1812.06298; Johannink et al., ICRA 2019); PPO (Schulman et
al. 2017), SAC (Haarnoja et al. 2018), TQC (Kuznetsov et al. 2020) as in stable-baselines3 and sb3-contrib. Departures:
features in units of each motor's own friction, one network for all motors, the last layer zero at first, the base acts
while replay buffers are filled (docs/agents/residual.md).

Train it, and run it:

    ffgym train policy --algorithm ppo --base elastic --seed 0 --out trained
    policy = load_policy("trained/policy.npz")

Logged: the reward per step while training, with exploration, in `meta["learning_curve"]` and TensorBoard.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ffgym.agents.declaration import AgentEntry, declare
from ffgym.agents.law_files import FORMAT, npz_target, pack, unpack
from ffgym.agents.residual.actor import Actor
from ffgym.agents.residual.bases import base_law
from ffgym.agents.residual.composition import AHEAD, Composition, CompositionMemory, take_where
from ffgym.control import ObservationLayout
from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.core.files import write_bytes
from ffgym.core.provenance import versions
from ffgym.core.types import Array
from ffgym.robot import RobotDescription


@dataclass(frozen=True, kw_only=True, eq=False)
class AgentState:
    """State of a residual agent from one decision to the next."""

    memory: CompositionMemory
    residual: Array
    """Last residual, in [-1, 1], shape (B, N)."""
    network: Array
    """State of the network, see `Actor.initial_state`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ResidualAgent:
    """A composition and the network on top of it."""

    composition: Composition
    actor: Actor

    def __post_init__(self) -> None:
        features = self.composition.features
        if (self.actor.n_motors, self.actor.n_features) != (features.layout.n_joints, features.size):
            raise FFGymError(
                f"A policy for {self.actor.n_motors} motors and {self.actor.n_features} features does not fit an "
                f"environment with {features.layout.n_joints} motors, which has {features.size}."
            )

    def predict(
        self,
        observation: Array,
        state: AgentState | None = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Array, AgentState]:
        """Compute actions (B, N) or (N,) for observations (B, D) or (D,), and the state for the next call.

        Args:
            observation: one observation, or a batch of them.
            state: state that the last call returned, None at first.
            episode_start: True where an episode begins, shape (B,) or (); None is nowhere.
            deterministic: without effect, a trained policy does not explore.

        Raises:
            FFGymError: if observations are of another environment, or the state is of another batch.
        """
        seen_now = np.asarray(observation)
        size = self.composition.features.layout.size
        if seen_now.ndim not in (1, 2) or seen_now.shape[-1] < size:
            raise FFGymError(
                f"Observations must have {size} numbers each, as those of the environment that this agent was made "
                f"for, got shape {seen_now.shape}."
            )
        # input of the policy: at the beginning of episodes, or after the last residual
        rows = np.atleast_2d(seen_now)
        if state is None:
            seen, network = self.composition.begin(rows), self.actor.initial_state((len(rows),))
            begins = np.ones(len(rows), dtype=np.bool_)
        else:
            if len(state.residual) != len(rows):
                raise FFGymError(
                    f"The state of {len(state.residual)} robots is not what predict returned for {len(rows)}; give "
                    f"None where a batch begins."
                )
            flags = np.zeros(len(rows)) if episode_start is None else episode_start
            begins = np.atleast_1d(np.asarray(flags, dtype=np.bool_))
            if begins.shape != (len(rows),):
                raise FFGymError(
                    f"episode_start has shape {begins.shape}, must be ({len(rows)},): one for each observation."
                )
            seen, network = self.composition.follow(state.memory, rows, state.residual), state.network
            # robots whose episode begins here have no past
            if begins.any():
                seen = take_where(begins, self.composition.begin(rows), seen)
        # residual of the network, and action of both together
        residual, network = self.actor.act(seen.features, network, begins)
        action = self.composition.action(seen, residual)
        known = AgentState(memory=seen.memory, residual=residual, network=network)
        return (action[0] if seen_now.ndim == 1 else action), known


KIND = "residual_policy"
"""Kind in the header of a policy's file."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ResidualPolicy:
    """A base law by name and a network, as an `ffgym.control.Policy`."""

    base: str
    """One of `ffgym.agents.residual.bases.BASES`."""
    machine: str | None = field(default=None, repr=False)
    """Text of the machine file that the base 'model' is made from."""
    actor: Actor = field(repr=False)
    memory: int
    """Samples of errors and residuals among the features."""
    bound: float
    """Largest residual torque, in units of each joint's breakaway torque."""
    action_scale: float
    """Torque of an action of 1 in breakaway torques, as the environment's keyword argument."""
    meta: Mapping[str, Any] = field(default_factory=dict, repr=False)
    """Origin: algorithm, hyper-parameters, seed, steps, environment, versions, learning curve."""
    preview: int = AHEAD[-1]
    """Samples of the reference that are observed, as the environment's keyword argument."""
    averaged: bool = True
    """True for errors less `CausalLaw.own_error`; False, as files without it, for those less
    `CausalLaw.instant_error`, which differ where friction acts on the arm."""

    def __post_init__(self) -> None:
        if not isinstance(self.base, str) or not isinstance(self.machine, str | None):
            raise FFGymError(f"base = {self.base!r} and machine = {self.machine!r} must be text.")
        if not isinstance(self.averaged, bool):
            raise FFGymError(f"averaged = {self.averaged!r} must be true or false.")
        check_whole("memory", self.memory, unit="samples", low=1, high=1000)
        check_number("bound of the residual", self.bound, unit="breakaway torques", low=0.0, open_low=True)
        check_number("action_scale", self.action_scale, unit="breakaway torques", low=0.0, open_low=True)
        check_whole("preview", self.preview, unit="samples", low=AHEAD[-1], high=1000)

    def agent(self, robot: RobotDescription, layout: ObservationLayout) -> ResidualAgent:
        """Make the agent of the policy in an environment.

        Args:
            robot: nominal description, on which the controller of the machine relies.
            layout: layout of the observations.

        Raises:
            FFGymError: if the robot has another number of motors, or too little of the reference is observed.
        """
        law = base_law(self.base, self.machine, robot)
        composition = Composition.over(law, robot, layout, memory=self.memory, bound=self.bound, averaged=self.averaged)
        return ResidualAgent(composition=composition, actor=self.actor)


def encode_policy(policy: ResidualPolicy) -> bytes:
    """Encode a policy as a file; equal policies give equal bytes."""
    own = {name: getattr(policy, name) for name in _SETTINGS}
    header = {
        "format": FORMAT,
        "kind": KIND,
        "settings": own | {"actor": policy.actor.settings()},
        "meta": dict(policy.meta),
        "versions": versions(),
    }
    return pack(header, policy.actor.arrays())


def save_policy(path: str | os.PathLike[str], policy: ResidualPolicy) -> Path:
    """Write a policy, whole or not at all.

    Raises:
        FFGymError: if the file cannot be written, or its name does not end in .npz.
    """
    target = npz_target(path, "policy")
    write_bytes(target, encode_policy(policy))
    return target


def load_policy(path: str | os.PathLike[str]) -> ResidualPolicy:
    """Read a policy that `save_policy` wrote.

    Raises:
        FFGymError: if the file is missing or damaged, or holds something else.
    """
    header, arrays = unpack(path)
    check_choice(f"kind of policy in {path}", str(header.get("kind")), [KIND])
    try:
        settings = dict(header["settings"])
        actor = Actor.from_parts(settings.pop("actor"), arrays)
        settings.setdefault("averaged", False)
        if set(settings) != set(_SETTINGS):
            raise FFGymError(f"settings {sorted(settings)} must be {sorted(_SETTINGS)}.")
        return ResidualPolicy(actor=actor, meta=header["meta"], **settings)
    except (KeyError, TypeError, AttributeError, FFGymError) as error:
        reason = str(error).rstrip(".")
        raise FFGymError(f"{path}: holds no complete residual policy: {reason}. Train it again.") from error


_SETTINGS = ("base", "machine", "memory", "bound", "action_scale", "preview", "averaged")


_EACH_MOTOR = "one small network for all motors"
_LSTM, _MEMORY = "an LSTM that sees all motors", "one small network that sees the last samples"
_ROBOTS, _MACHINES = "robots", "machines with real drives and other effects"


@dataclass(frozen=True)
class ResidualRow:
    """A row of trained residual policies on the leaderboard."""

    algorithm: str
    base: str
    title: str
    network: str = _EACH_MOTOR
    machines: bool = False
    """True if it is trained on machines with effects, see `Training.machines`; False on robots."""


RESIDUALS: Mapping[str, ResidualRow] = MappingProxyType(
    {
        "ppo_elastic": ResidualRow("ppo", "elastic", "PPO on elastic"),
        "sac_elastic": ResidualRow("sac", "elastic", "SAC on elastic"),
        "tqc_elastic": ResidualRow("tqc", "elastic", "TQC on elastic"),
        "recurrent_ppo_elastic": ResidualRow("recurrent_ppo", "elastic", "recurrent PPO on elastic", _LSTM),
        "ppo_elastic_memory": ResidualRow("ppo", "elastic", "PPO on elastic, memory", _MEMORY),
        "ppo_lugre": ResidualRow("ppo", "lugre_dynamic", "PPO on dynamic LuGre"),
        "ppo_none": ResidualRow("ppo", "none", "PPO on nothing"),
        "ppo_drives": ResidualRow("ppo", "elastic", "PPO on elastic, drives", machines=True),
        "sac_drives": ResidualRow("sac", "elastic", "SAC on elastic, drives", machines=True),
        "tqc_drives": ResidualRow("tqc", "elastic", "TQC on elastic, drives", machines=True),
        "recurrent_ppo_drives": ResidualRow(
            "recurrent_ppo", "elastic", "recurrent PPO on elastic, drives", _LSTM, machines=True
        ),
    }
)
"""Trained residual policies. They have rows where they are published."""

_ON = {"none": "no compensation", "lugre_dynamic": "dynamic LuGre", "elastic": "elastic feed-forward"}

declare(
    *(
        AgentEntry(
            name=name,
            title=row.title,
            about=f"A bounded residual torque on {_ON[row.base]}: {row.network}, trained in simulation at p1 on "
            f"{_MACHINES if row.machines else _ROBOTS} drawn about the nominal one; it never met the machine that it "
            f"is scored on.",
            track="causal, nominal parameters",  # without a base too: it was trained on robots about the nominal one
            order=20 + i,
            page="residual.md",
            load=lambda path, arm: load_policy(path),
            base=row.base,
            feedback=True,
        )
        for i, (name, row) in enumerate(RESIDUALS.items())
    )
)
