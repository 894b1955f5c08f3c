"""Residual policies as ONNX, scaling and memory inside, compared with the simulation before they are written.

A policy adds a bounded torque to that of a law. The file has what is above the law: physical errors of the motors and
the reference ahead go in, torque [N m] comes out. The law itself runs beside it, e.g. as C.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ffgym.agents.residual.composition import AHEAD, Composition, CompositionMemory
from ffgym.agents.residual.policy import AgentState, ResidualAgent, ResidualPolicy
from ffgym.control import ObservationLayout
from ffgym.control.observation import BOUND, ahead
from ffgym.core.errors import FFGymError
from ffgym.core.files import write_bytes
from ffgym.core.provenance import is_installed
from ffgym.core.types import Array
from ffgym.core.version import __version__
from ffgym.leaderboard.evaluation.closed_loop import run_references
from ffgym.paths import Reference
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation import SimulatedRig

TOLERANCE = 1e-6
"""Largest difference from the simulation, as a share of the policy's largest torque, `bound` breakaway torques."""
ERRORS = ("error", "error_rate")
"""Inputs of the motors' errors, and endings of those that the law below causes itself."""


@dataclass(frozen=True, kw_only=True)
class PolicyCheck:
    """Comparison of a policy in ONNX with the simulation, in closed loop along a motion."""

    motion: str
    decisions: int
    largest_difference: float
    """Largest difference of a torque as a share of the policy's largest torque [1]."""


def write_policy_onnx(
    policy: ResidualPolicy,
    robot: RobotDescription,
    reference: Reference,
    path: str | os.PathLike[str],
    *,
    single: bool = False,
) -> PolicyCheck:
    """Write a policy for a robot as ONNX.

    Args:
        policy: the policy.
        robot: nominal description, on which its controller relies, and which scales its observations.
        reference: motion along which it is compared, in closed loop with the simulated robot.
        path: file to write.
        single: True computes with numbers of 32 bits, for runtimes that have no others; False with 64 bits, as the
            simulation does.

    Raises:
        FFGymError: if a package is missing, the policy does not fit the robot, or the torques differ; nothing is
            written then.
    """
    missing = [name for name in ("onnx", "onnxruntime") if not is_installed(name)]
    if missing:
        raise FFGymError(f"A policy in ONNX needs {' and '.join(missing)}: pip install 'ffgym[onnx]'.")
    data = encode_onnx(policy, robot, single=single)
    check = check_onnx(data, policy, robot, reference)
    if not check.largest_difference <= TOLERANCE:
        raise FFGymError(
            f"The policy in ONNX differs from the simulation by {check.largest_difference:.2g} of its largest torque "
            f"along {reference.name}, may by {TOLERANCE:g}; nothing is written. "
            + ("Leave out --single: 64 bits are exact." if single else "Please report it, with the policy.")
        )
    write_bytes(path, data)
    return check


def encode_onnx(policy: ResidualPolicy, robot: RobotDescription, *, single: bool = False) -> bytes:
    """Encode a policy for a robot as the bytes of an ONNX file."""
    from ffgym.deployment.code.onnx_graph import OnnxGraph

    agent = _agent(policy, robot)
    n, graph = robot.n_joints, OnnxGraph(np.float32 if single else np.float64)
    given = {name: graph.give(name, shape) for name, shape in _input_shapes(agent).items()}
    begins = graph.give("begins", (1,), np.bool_)
    observation = _Observation.of(given, agent.composition.features.layout)
    # features at the beginning of a motion, or after the last residual; then the network
    own = tuple(given[f"law_{name}"] for name in ERRORS)
    symbols: Any = {"own": own, "past": given["past"]}
    memory = CompositionMemory(law=np.zeros((1, 0)), **symbols)
    composition: Any = replace(agent.composition, base=None)
    fresh = composition.begin(observation)
    later = composition.follow(memory, observation, given["residual"])
    features = np.where(begins[:, None], fresh.features, later.features)
    past = np.where(begins[:, None, None, None], fresh.memory.past, later.memory.past)
    state: Any = given.get("network", agent.actor.initial_state((1,)))
    actor: Any = agent.actor
    residual, network = actor.act(features, state, begins if "network" in given else None)
    torque = residual * (policy.bound * robot.friction.static)
    outputs: dict[str, Any] = {"torque": torque, "past_next": past, "residual_next": residual}
    if "network" in given:
        outputs["network_next"] = network
    notes = {
        "about": f"Residual policy on {policy.base} for {robot.name}, {n} motors; written by ffgym {__version__}.",
        "reference_samples": ", ".join(map(str, AHEAD)),
        "control_dt": repr(robot.servo.control_dt),
        "law_error": "own_error" if policy.averaged else "instant_error",
        "largest_torque": ", ".join(map(repr, (policy.bound * robot.friction.static).tolist())),
    }
    data: bytes = graph.model(outputs, "policy", notes).SerializeToString()
    return data


def _agent(policy: ResidualPolicy, robot: RobotDescription) -> ResidualAgent:
    layout = ObservationLayout(robot, policy.preview, policy.action_scale * robot.friction.static)
    return policy.agent(robot, layout)


def _input_shapes(agent: ResidualAgent) -> dict[str, tuple[int, ...]]:
    """Shapes of the inputs by name; the first axis is 1, one robot."""
    n, composition = agent.actor.n_motors, agent.composition
    shapes: dict[str, tuple[int, ...]] = dict.fromkeys(ERRORS, (1, n))
    shapes |= {f"reference_{name}": (1, len(AHEAD), n) for name in ("velocity", "acceleration")}
    shapes |= {f"law_{name}": (1, n) for name in ERRORS}
    shapes |= {"past": (1, composition.features.memory, 3, n), "residual": (1, n)}
    if agent.actor.lstm is not None:
        shapes["network"] = (1, 2, agent.actor.lstm.cells)
    return shapes


class _Observation:
    """Observation of which entries are known one by one."""

    def __init__(self, layout: ObservationLayout) -> None:
        self._layout, self._known = layout, dict[int, Any]()

    @classmethod
    def of(cls, given: Mapping[str, Any], layout: ObservationLayout) -> "_Observation":
        """Bring physical readings to the scales of observations."""
        found = cls(layout)
        for name in ERRORS:
            found._add(name, given[name])
        for k, samples in enumerate(AHEAD):
            for name in ("reference_velocity", "reference_acceleration"):
                found._add(ahead(name, samples), given[name][:, k])
        return found

    def _add(self, name: str, value: Any) -> None:
        entry = self._layout[name]
        self._known[entry.slice.start] = np.clip(value / entry.scale, -BOUND, BOUND)

    def __len__(self) -> int:
        return 1

    def __getitem__(self, key: Any) -> Any:
        return self._known[key[-1].start]


@dataclass(frozen=True, kw_only=True, eq=False)
class _LoggedPolicy:
    """A policy whose decisions are logged."""

    policy: ResidualPolicy
    log: list[tuple[Array, tuple[Array, Array], Array]] = field(default_factory=list)
    """Observation, errors that the law causes, and residual of each decision, (1, ...) each."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self.policy, name)

    def agent(self, robot: RobotDescription, layout: ObservationLayout) -> "_LoggedAgent":
        """Make the agent."""
        return _LoggedAgent(self.policy.agent(robot, layout), self.log)


@dataclass(frozen=True, eq=False)
class _LoggedAgent:
    agent: ResidualAgent
    log: list[tuple[Array, tuple[Array, Array], Array]]

    def predict(
        self, observation: Array, state: AgentState | None = None, starts: Any = None, deterministic: bool = True
    ) -> tuple[Array, AgentState]:
        still = np.zeros((len(observation), self.agent.actor.n_motors))
        own = (still, still) if state is None else state.memory.own
        action, later = self.agent.predict(observation, state, starts, deterministic)
        self.log.append((observation.copy(), own, later.residual))
        return action, later


def check_onnx(data: bytes, policy: ResidualPolicy, robot: RobotDescription, reference: Reference) -> PolicyCheck:
    """Compare a policy in ONNX with the simulation: both see what the simulated robot does under the latter.

    The file keeps its own memory along the motion, so that differences add up as they do on a machine.
    """
    import onnxruntime

    logged: Any = _LoggedPolicy(policy=policy)
    run_references(SimulatedRig(arm=RigidArm(robot)), logged, [reference])
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    session = onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])
    dtype = np.float64 if "double" in session.get_inputs()[0].type else np.float32
    agent = _agent(policy, robot)
    state = {name: np.zeros(shape) for name, shape in _input_shapes(agent).items() if name in _STATE}
    names = [output.name for output in session.get_outputs()]
    differences = []
    for k, (observation, own, residual) in enumerate(logged.log):
        inputs = _readings(observation, own, agent.composition) | state
        feed = {name: np.asarray(value, dtype=dtype) for name, value in inputs.items()}
        found = dict(zip(names, session.run(None, feed | {"begins": np.array([k == 0])}), strict=True))
        state = {name: found[f"{name}_next"] for name in state}
        torque = found["torque"] / (policy.bound * robot.friction.static)
        differences.append(np.abs(torque - residual).max())
    return PolicyCheck(motion=reference.name, decisions=len(differences), largest_difference=float(np.max(differences)))


_STATE = ("past", "residual", "network")
"""Inputs that are outputs of the step before, whose names end with _next."""


def _readings(observation: Array, own: tuple[Array, Array], composition: Composition) -> dict[str, Array]:
    """Physical inputs for an observation."""
    layout = composition.features.layout
    found = {name: layout.read(observation, name) for name in ERRORS}
    found |= {f"law_{name}": value for name, value in zip(ERRORS, own, strict=True)}
    for name in ("reference_velocity", "reference_acceleration"):
        found[name] = np.stack([layout.read(observation, name, ahead_by=k) for k in AHEAD], axis=1)
    return found
