"""Learned laws, states of learning, residual policies, and the manifests of trained agents."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.agents.amortised.estimator import Estimator
from ffgym.agents.artefacts import TRAINED, locate_artefact, read_manifest
from ffgym.agents.catalogue import make_law
from ffgym.agents.declaration import AgentSetting
from ffgym.agents.law_files import StateFile, load_law, pack, save_law, unpack
from ffgym.agents.residual.policy import KIND, encode_policy, load_policy
from ffgym.agents.submission import load, resolve_agent
from ffgym.agents.task_torques import MotionTorque, TaskTorques
from ffgym.agents.tensor_bspline import TensorBSN
from ffgym.paths import Reference, load_motion
from ffgym.robot import RigidArm, load_robot
from scripts.fuzz.reader import Make, Reader

_ROBOT = "irb4600_60_205"
_STATE = {"law": "mlp_fel", "rate": 0.1, "layers": [8, 8]}


def _trained(name: str) -> Make:
    """Take the smallest file of a trained agent."""

    def make(folder: Path) -> Path:
        files = sorted((TRAINED / name).rglob("*.npz"), key=lambda file: (file.stat().st_size, str(file)))
        (folder / "agent.npz").write_bytes(files[0].read_bytes())
        return folder / "agent.npz"

    return make


def _task_torques(folder: Path) -> Path:
    q = np.linspace(0.0, 0.1, 12).reshape(6, 2)
    return save_law(
        folder / "agent.npz", TaskTorques(tasks=(MotionTorque(name="line", q=q, torque=q - q[0]),)), {"x": 1}
    )


def _tensor(folder: Path) -> Path:
    """A network over speed and position that was not trained."""
    law = TensorBSN.along([_reference()])
    return save_law(folder / "agent.npz", law)


@cache
def _reference() -> Reference:
    """A motion of the built-in robot, along which laws are computed."""
    arm = RigidArm(load_robot(_ROBOT))
    return load_motion(arm, "rounded_square").reference


def _use_law(path: Path) -> None:
    """Read a law and compute it along a motion, if it is for the robot."""
    law: Any = load_law(path)
    if getattr(law, "n_joints", 6) == 6:
        law.torque(_reference())


def _use_policy(path: Path) -> None:
    encode_policy(load_policy(path))


def _use_source(path: Path) -> None:
    resolve_agent(str(path))


def _state(folder: Path) -> Path:
    StateFile(path=folder / "state.npz", kind="learning", settings=_STATE).write({"weights": np.arange(6.0)})
    return folder / "state.npz"


def _read_state(path: Path) -> None:
    StateFile(path=path, kind="learning", settings=_STATE).read()


def _manifest(folder: Path) -> Path:
    """The manifest of a small agent with its files."""
    for file in (TRAINED / "narx").rglob("*"):
        if file.is_file() and (file.suffix == ".json" or file.name == "seed_0.npz"):
            place = folder / "narx" / file.relative_to(TRAINED / "narx")
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(file.read_bytes())
    return folder


def _read_manifest(path: Path) -> None:
    uncached: Callable[..., Any] = read_manifest.__wrapped__
    found = uncached("narx", path)
    for artefact in () if found is None else found.artefacts[:1]:
        locate_artefact("narx", artefact, path)


def _use_machine(path: Path) -> None:
    make_law(str(path), AgentSetting.of(load_robot(_ROBOT)))


def _use_estimator(path: Path) -> None:
    Estimator.load(path)


def _load_submitted(path: Path) -> None:
    """Load the agent of a submission as its process does, a law and then a policy."""
    kind = "policy" if unpack(path)[0].get("kind") == KIND else "law"
    load({"kind": kind, "file": path.name, "law": None}, path.parent, load_robot(_ROBOT))


_LAWS = ("bsn_static", "bsn_extended", "mlp_fel", "narx")

READERS = (
    Reader(name="law", use=_use_law, makes=tuple(map(_trained, _LAWS)), covers=(load_law, unpack, pack), share=12),
    Reader(name="law_of_tasks", use=_use_law, makes=(_task_torques, _tensor), covers=(load_law,), share=8),
    Reader(name="law_by_name", use=_use_machine, makes=(_trained("mlp_fel"),), covers=(make_law,), share=4),
    Reader(
        name="policy",
        use=_use_policy,
        makes=tuple(map(_trained, ("tqc_drives", "ppo_elastic_memory"))),
        covers=(load_policy,),
        share=12,
    ),
    Reader(name="agent_to_submit", use=_use_source, makes=(_trained("bsn_static"),), covers=(resolve_agent,), share=4),
    Reader(name="estimator", use=_use_estimator, makes=(_trained("amortised"),), covers=(Estimator.load,), share=2),
    Reader(
        name="agent_of_a_submission",
        use=_load_submitted,
        makes=(_trained("mlp_fel"), _trained("tqc_drives")),
        covers=(load,),
        share=3,
    ),
    Reader(name="state_of_learning", use=_read_state, makes=(_state,), covers=(StateFile,), share=8),
    Reader(
        name="manifest_of_agents",
        use=_read_manifest,
        makes=(_manifest,),
        covers=(read_manifest, locate_artefact),
        share=10,
    ),
)
