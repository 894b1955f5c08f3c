"""Play an exported motion in plain MuJoCo and compare every recorded row: `python play.py`.

Needs numpy and mujoco, nothing else. From the state in keyframe `start`, each physics step gets a row of
`controls.csv` as `data.ctrl`. Prints the largest difference of each quantity from `recording.csv`; the exit code is 1
if one is above TOLERANCE, or if the files do not belong together.
"""

import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

TOLERANCE = 1e-9
"""Largest difference that counts as equal, in SI units: far above rounding, far below what matters on a robot."""

Signal = Callable[[Any], Any]
"""Reads one quantity, shape (N,), from `mujoco.MjData`."""


def main(folder: Path) -> int:
    """Play the motion in `folder`; returns the exit code."""
    model = mujoco.MjModel.from_xml_path(str(folder / "model.xml"))
    controls = np.loadtxt(folder / "controls.csv", delimiter=",", skiprows=1, ndmin=2)
    header, recording = read_recording(folder / "recording.csv")
    made_with = header["provenance"]["mujoco"]
    if mujoco.__version__ != made_with:
        print(f"recorded with MuJoCo {made_with}, played with {mujoco.__version__}: last digits may differ")
    signals = signals_of(model, header["joints"])
    time = recording["timestamp"]
    stride = round((time[1] - time[0]) / model.opt.timestep)  # physics steps between recorded rows
    if len(controls) - 1 != stride * (len(time) - 1):
        print(
            f"{len(controls) - 1} steps do not fit {len(time)} recorded rows, {stride} steps apart: a file is cut off"
        )
        return 1
    print("largest difference, SI units")
    worst = 0.0
    for name, played in play(model, controls, signals, stride).items():
        parts = "xyz" if name == "tcp.position" else header["joints"]
        recorded = np.stack([recording[f"{name}.{part}"] for part in parts], axis=1)
        difference = np.abs(played - recorded).max()
        print(f"{name:<18} {difference:.3g}")
        worst = np.maximum(worst, difference)  # which keeps NaN
    print(f"{len(controls) - 1} steps, {len(recorded)} recorded rows, largest difference {worst:.3g}")
    return 0 if worst <= TOLERANCE else 1


def play(model: Any, controls: Any, signals: dict[str, Signal], stride: int) -> dict[str, Any]:
    """Simulate signals, shape (rows, N) each, at every `stride`-th step of a motion with `controls` (steps, nu)."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
    rows: dict[str, list[Any]] = {name: [] for name in signals}
    for k, row in enumerate(controls):
        data.ctrl[:] = row
        if k % stride == 0:
            mujoco.mj_forward(model, data)  # forces and positions that belong to this instant
            for name, signal in signals.items():
                rows[name].append(np.array(signal(data)))
        mujoco.mj_step(model, data)
    return {name: np.stack(values) for name, values in rows.items()}


def signals_of(model: Any, joints: Sequence[str]) -> dict[str, Signal]:
    """Return readers of all signals that a recording may have; motor quantities are motor side."""
    servo = [at for at in _actuators(model, joints, "servo") if at >= 0]
    integrals = [_integral(model, at) for at in servo]
    qpos, dof = (_addresses(model, joints, at) for at in (model.jnt_qposadr, model.jnt_dofadr))
    signals: dict[str, Signal] = {
        "motor.position": lambda data: data.actuator_length[servo],
        "motor.velocity": lambda data: data.actuator_velocity[servo],
        "motor.effort": lambda data: [_read_command(model, data, at) for at in servo],
        "feedback.integral": lambda data: [k * data.act[i] if i >= 0 else 0.0 for k, i in integrals],
        "link.position": lambda data: [data.qpos[at].sum() for at in qpos],
        "link.velocity": lambda data: [data.qvel[at].sum() for at in dof],
    }
    motors, arms = (_actuators(model, joints, kind) for kind in ("friction", "arm_friction"))
    behind = any(at >= 0 for at in arms)
    if behind or any(at >= 0 for at in motors):
        signals["friction.effort"] = lambda data: [_friction(model, data, at) for at in motors]
    if behind:  # in motor units, times the gear ratio, which the tendon of the link has as coefficient
        gears = [model.wrap_prm[model.tendon_adr[model.actuator_trnid[at, 0]]] if at >= 0 else 0.0 for at in arms]
        signals["arm_friction.effort"] = lambda data: [
            gear * _friction(model, data, at) for gear, at in zip(gears, arms, strict=True)
        ]
    if any(model.site(i).name == "tcp" for i in range(model.nsite)):
        signals["tcp.position"] = lambda data: data.site("tcp").xpos
    return signals


def read_recording(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Read header and columns by name of a recording: JSON in comment lines, a row of names, one row per sample."""
    with path.open(encoding="utf-8") as file:
        comments = []
        for line in file:
            if not line.startswith("#"):
                break
            comments.append(line[1:])
        values = np.loadtxt(file, delimiter=",", ndmin=2)
    names = line.strip().split(",")
    return json.loads("".join(comments[1:])), dict(zip(names, values.T, strict=True))


def _read_command(model: Any, data: Any, at: int) -> float:
    """Torque that a servo commands: its force, or what goes into its torque loop, if it is a `dcmotor`."""
    if model.actuator_gaintype[at] != mujoco.mjtGain.mjGAIN_DCMOTOR:
        return float(data.actuator_force[at])
    kp, ki, kv = model.actuator_gainprm[at, 4:7]
    position, speed, torque = data.ctrl[model.actuator_ctrladr[at] :][:3]
    command = kp * (position - data.actuator_length[at]) + kv * (speed - data.actuator_velocity[at]) + torque
    if ki > 0:
        command += ki * data.act[model.actuator_actadr[at]]
    return float(np.clip(command, *model.actuator_forcerange[at]))


def _integral(model: Any, at: int) -> tuple[float, int]:
    """Integral gain of a servo, and the address of its integral, -1 if it has none."""
    loop = model.actuator_gaintype[at] == mujoco.mjtGain.mjGAIN_DCMOTOR
    gain = float(model.actuator_gainprm[at, 5 if loop else 0])
    return gain, int(model.actuator_actadr[at]) if gain > 0 else -1


def _friction(model: Any, data: Any, at: int) -> float:
    """Friction torque of an actuator, 0 where there is none: bristles are its force, viscous friction its damping."""
    if at < 0:
        return 0.0
    return float(model.actuator_damping[at] * data.actuator_velocity[at] - data.actuator_force[at])


def _actuators(model: Any, joints: Sequence[str], kind: str) -> list[int]:
    """Return the actuator of each joint, -1 where it has none of this kind."""
    names = {model.actuator(i).name: i for i in range(model.nactuator)}
    return [names.get(f"{joint}_{kind}", -1) for joint in joints]


def _addresses(model: Any, joints: Sequence[str], at: Any) -> list[list[int]]:
    """Return the coordinates of each joint: of its motor, and of its deflection if it is elastic."""
    names = {model.joint(i).name: i for i in range(model.njnt)}
    both = [(f"{joint}_motor", f"{joint}_deflection") for joint in joints]
    return [[int(at[names[name]]) for name in pair if name in names] for pair in both]


if __name__ == "__main__":
    sys.exit(main(Path(__file__).resolve().parent))
