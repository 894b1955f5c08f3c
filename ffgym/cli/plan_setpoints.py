"""`ffgym plan`: the set-points of a motion, corrected by a feed-forward law, for streams and programs."""

from dataclasses import replace

import numpy as np

from ffgym.cli.export import load_machine_or_robot, prepare_motion
from ffgym.cli.laws import check_laws
from ffgym.cli.outputs import claim_outputs, given_options, print_places, provenance, write_numbers
from ffgym.cli.stream_options import PlanSetpoints
from ffgym.control import CorrectionLimits, NoCompensation, SetpointResponse
from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.deployment.controller_file import read_controller, read_servo
from ffgym.deployment.plan import SetpointPlan, write_plan
from ffgym.deployment.planning import plan_probe, plan_setpoints
from ffgym.robot import ModelOptions, RigidArm, RobotDescription, physics_fingerprint
from ffgym.robot.parts import Servo
from ffgym.simulation.plant import Machine


def run(config: PlanSetpoints) -> None:
    """Check, plan, write, print."""
    check_choice("plan format", config.out.suffix, [".npz"])
    inputs = (config.robot, config.path, config.parameters, config.controller, config.feedforward)
    claim_outputs({"--out": config.out, "--json": config.json}, inputs=inputs)
    known, machine = load_machine_or_robot(config.robot)
    if config.path is None:
        plan, machine, notes = _plan_probe(config, RigidArm(known), machine)
    else:
        found = _find_servo(config, known)
        if found is not None:
            known, machine = replace(known, servo=found), _with_servo(machine, known, found)
        plan, machine, notes = _plan_motion(config, RigidArm(known), machine, found is not None)
    write_plan(plan, config.out)
    fingerprint = physics_fingerprint(machine.spec(ModelOptions(looks=False)).compile())
    info = provenance("ffgym plan", config, plan.robot, fingerprint, config.seed if config.path is None else None)
    info |= {"motion": plan.name, "feedforward_law": plan.law, "plan": dict(plan.meta)}
    write_numbers(config, info | {"largest_correction": plan.largest_correction.tolist()})
    print("\n".join([*_describe(plan), *(f"note: {note}" for note in notes)]))
    print_places(plan=config.out, numbers=config.json)


def _find_servo(config: PlanSetpoints, robot: RobotDescription) -> Servo | None:
    """Read the servo that was identified; None for that of the description."""
    if config.controller is None or config.gains == "description":
        return None
    return read_servo(config.controller, robot)


def _with_servo(machine: Machine, known: RobotDescription, servo: Servo) -> Machine:
    """Give a machine the servo that was found."""
    if machine.robot is known:
        return Machine.of(replace(known, servo=servo))
    return replace(machine, robot=replace(machine.robot, servo=servo))


def _plan_motion(
    config: PlanSetpoints, arm: RigidArm, machine: Machine, found: bool
) -> tuple[SetpointPlan, Machine, tuple[str, ...]]:
    """Plan a motion with its law."""
    if given := given_options(config, ("largest_speed_rad_s", "seconds", "seed")):
        raise FFGymError(f"{given[0]} has no effect on a motion. Leave it out, or leave out the motion.")
    check_laws([config.feedforward], "--feedforward")
    response = SetpointResponse() if config.controller is None else read_controller(config.controller)
    limits = None
    if config.largest_mrad is not None:
        size = check_number("--largest-mrad", config.largest_mrad, unit="mrad", low=0.0, open_low=True)
        limits = CorrectionLimits.even(arm.robot.n_joints, size=1e-3 * size)
    assert config.path is not None
    ready = prepare_motion(config, config.robot, config.path, arm, machine, ModelOptions(looks=False))
    plan = plan_setpoints(
        ready.motion.reference,
        ready.law,
        arm=ready.arm,
        response=response,
        sends=config.sends,
        feedforward=config.controller_feedforward,
        limits=limits,
        meta={"gains": "controller" if found else "description"},
    )
    return plan, ready.machine, tuple(ready.motion.notes)


def _plan_probe(
    config: PlanSetpoints, arm: RigidArm, machine: Machine
) -> tuple[SetpointPlan, Machine, tuple[str, ...]]:
    """Plan the motion that shows delay and filter of a controller."""
    names = (
        "entry",
        "inputs",
        "cycles",
        "feedforward",
        "parameters",
        "controller",
        "gains",
        "sends",
        "controller_feedforward",
        "largest_mrad",
    )
    if given := given_options(config, names):
        raise FFGymError(f"{', '.join(given)} has no effect without a motion. Name one after the robot.")
    speed = check_number("--largest-speed-rad-s", config.largest_speed_rad_s, unit="rad/s", low=0.0, open_low=True)
    seed = check_whole("--seed", config.seed, low=0)
    plan = plan_probe(arm, np.random.default_rng(seed), peak_speed=speed, duration=config.seconds)
    return plan, machine, ()


def _describe(plan: SetpointPlan) -> list[str]:
    """Say what a plan is."""
    lines = [f"{plan.name} with {plan.law}: {plan.t[-1]:g} s, {len(plan.t)} set-points every {plan.dt * 1e3:g} ms"]
    if plan.law == NoCompensation.name:
        return lines
    largest = ", ".join(
        f"{joint} {1e3 * size:.3f}" for joint, size in zip(plan.joints, plan.largest_correction, strict=True)
    )
    lines.append(f"gains of the servo: those of the {plan.meta['gains']}")
    lines.append(f"largest correction [mrad, mm]: {largest}")
    if plan.meta["beyond_limits"]:
        lines.append("note: the correction was cut to its limits, and gives less than the law's torque there")
    return lines
