"""`ffgym export policy`: a residual policy as ONNX."""

from dataclasses import asdict
from pathlib import Path

from ffgym.agents.artefacts import ANYWHERE, locate_artefact, read_manifest
from ffgym.agents.residual.policy import RESIDUALS, ResidualPolicy, load_policy
from ffgym.cli.code_options import ExportPolicy
from ffgym.cli.outputs import claim_outputs, need_extra, print_places, provenance, write_numbers
from ffgym.core.errors import FFGymError, check_choice
from ffgym.deployment.code import write_policy_onnx
from ffgym.envs.machines import load_described_robot
from ffgym.paths.motions import load_motion
from ffgym.robot import ModelOptions, RigidArm, physics_fingerprint
from ffgym.simulation.plant import Machine


def run(config: ExportPolicy) -> None:
    """Check, record the formulas, compare, write, print."""
    inputs = (config.policy, config.robot, config.motion)
    claim_outputs({"--out": config.out, "--json": config.json}, inputs=inputs, suffix=".onnx")
    need_extra("A policy in ONNX", "onnx", "onnxruntime", extra="onnx")
    policy = _find_policy(config.policy)
    robot = load_described_robot(config.robot)
    motion = load_motion(RigidArm(robot), config.motion)
    if motion.reference.robot is not robot:
        raise FFGymError(
            f"{config.motion} brings a tool of its own; describe the robot with it, and give it as --robot."
        )
    check = write_policy_onnx(policy, robot, motion.reference, config.out, single=config.single)
    # origin of the file, and what was found
    fingerprint = physics_fingerprint(Machine.of(robot).spec(ModelOptions(looks=False)).compile())
    info = provenance("ffgym export policy", config, robot.name, fingerprint, seed=None)
    write_numbers(config, info | {"base": policy.base, "check": asdict(check)})
    print(f"residual policy on {policy.base}, {check.decisions} decisions along {check.motion}")
    print(f"largest difference from the simulation: {check.largest_difference:.2g} of its largest torque")
    print_places(policy=config.out, numbers=config.json)


def _find_policy(name: str) -> ResidualPolicy:
    """Load a policy by the name of a trained one, of which it takes the first seed, or by its file."""
    if name.endswith(".npz"):
        return load_policy(name)
    names = [
        known for known in (*RESIDUALS, "servo_gains", "servo_gains_drives", "servo_gains_stable") if _locate(known)
    ]
    return load_policy(_locate(check_choice("trained policy", name, names)) or name)


def _locate(name: str) -> Path | None:
    """Locate the first trained policy of a name; None if there is none."""
    manifest = read_manifest(name)
    for artefact in () if manifest is None else manifest.artefacts:
        if artefact.plant == ANYWHERE:
            return locate_artefact(name, artefact)
    return None
