"""Feed-forward from models on circles: docs/agents/elastic.md (15 minutes) and docs/agents/model.md (three minutes)."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ffgym.agents import IterativeLearning, SimulatedTrial, dynamic_lugre
from ffgym.agents.elastic import elastic_feedforward, elastic_law
from ffgym.agents.model import left_alone, model_law
from ffgym.control import FeedForwardLaw, NoCompensation
from ffgym.effects import EFFECTS, Effect
from ffgym.paths import RADII, SPEEDS
from ffgym.robot import RigidArm, RobotDescription, load_robot
from ffgym.simulation import SimulatedRig
from ffgym.simulation.plant import Climate, Machine
from ffgym.studies import CircleStudy, circle_references, circle_study
from scripts.tables.page import Contents, markdown

WARM = Climate(ambient=20.0, rise=np.array([25.0]), running_since=3600.0)
"""Climate of the machines with an effect, so that effects of temperature and time show."""
SHARES = (0.0, 0.25, 0.5, 0.73)
"""Shares of friction behind the elasticity of joints 1 to 3; the last fits Tables 4.1 and 4.2 of the thesis best."""
BELIEVED = (0.0, 0.53, 0.63, 0.73, 0.83, 0.93)
"""Shares that a law believes in on a robot with the last of `SHARES`."""


def elastic(
    robot: str = "irb4600_60_205",
    positions: Sequence[str] | None = None,
    speeds: Sequence[float] = SPEEDS,
    radii: Sequence[float] = RADII,
) -> Contents:
    """Compare elastic feed-forward with right and wrong models: mean RMS path error [mm]."""
    described = load_robot(robot)
    cases: dict[str, dict[str, tuple[RobotDescription, FeedForwardLaw]]] = {
        "law": {law.name: (described, law) for law in laws_of(described)},
        "machine": {name: (each, elastic_feedforward(each)) for name, each in machines_of(described).items()},
    }
    task = (positions, speeds, radii)
    parts = {f"{what}s": _compare(what, rows, *task) for what, rows in cases.items()}
    parts["shares"] = arm_friction(described, *task)
    # the last share, wrong in the law, and without what limits it
    behind = with_arm_share(described, SHARES[-1])
    believed = {f"{share:g}": RigidArm(with_arm_share(described, share)) for share in BELIEVED}
    wrong = {key: (behind, elastic_law(arm, name=key)) for key, arm in believed.items()}
    parts["believed shares"] = _compare("share in the law", wrong, *task)
    others = {key: (each, elastic_feedforward(each)) for key, each in machines_of(behind).items()}
    parts["machines with a share"] = _compare("machine", others, *task)
    return Contents(parts=parts)


def arm_friction(
    robot: RobotDescription, positions: Sequence[str] | None, speeds: Sequence[float], radii: Sequence[float]
) -> str:
    """Compare laws on robots with shares of friction behind the elasticity: mean RMS path error [mm].

    Every law knows the parameters of the robot, but for elastic feed-forward that knows nothing of the share.
    """
    rows = []
    for share in SHARES:
        arm = RigidArm(with_arm_share(robot, share))
        references = list(circle_references(arm, positions, speeds, radii).values())
        learning = IterativeLearning(arm=arm, target="tcp", base=elastic_law(arm))
        learned = learning.learn(references, SimulatedTrial(arm=arm)).law
        laws = {
            "none": NoCompensation(),
            "dynamic LuGre": dynamic_lugre(arm.robot),
            "elastic, share unknown": elastic_law(RigidArm(robot), name="unaware"),
            "elastic": elastic_law(arm),
            "`ilc_tcp`": learned,
        }
        study = circle_study(arm.robot, laws=list(laws.values()), positions=positions, speeds=speeds, radii=radii)
        for name, law in laws.items():
            rows.append((f"{share:g}", name, *(f"{error:.4f}" for error in _mean_rms(study, law, speeds))))
    return markdown(("share", "law", *_heads(speeds)), rows)


def with_arm_share(robot: RobotDescription, share: float) -> RobotDescription:
    """The robot with a share of the friction of its first three joints, or fewer, behind their elasticity."""
    return robot.with_arm_share(np.where(np.arange(robot.n_joints) < 3, share, 0.0))


def laws_of(robot: RobotDescription) -> list[FeedForwardLaw]:
    """Dynamic LuGre, and elastic feed-forward whole, in parts, and wrong by what one may expect."""
    law, arm, drive, bodies = elastic_feedforward(robot), RigidArm(robot), robot.drive, robot.bodies
    springs = elastic_feedforward(robot, compensate_friction=False)
    named: list[FeedForwardLaw] = [replace(springs, name="springs without friction")]
    named += [replace(law, preview=preview, name=f"{preview} samples ahead") for preview in (3, 5)]
    models = {}
    for percent in (-20, -10, 10, 20):
        factor = 1 + percent / 100
        soft = replace(
            drive, joint_stiffness=drive.joint_stiffness * factor, joint_damping=drive.joint_damping * factor
        )
        models[f"stiffness {percent:+d} %"] = replace(robot, drive=soft)
    for percent in (-30, 30):
        factor = 1 + percent / 100
        friction = robot.friction.scale(coulomb=factor, static=factor, viscous=factor)
        models[f"friction {percent:+d} %"] = replace(robot, friction=friction)
    for percent in (-5, 5):
        factor = 1 + percent / 100
        links = replace(bodies, mass=bodies.mass * factor, inertia=bodies.inertia * factor)
        models[f"link masses {percent:+d} %"] = replace(robot, bodies=links)
    wrong = [elastic_law(RigidArm(model), arm, name) for name, model in models.items()]
    return [dynamic_lugre(robot), law, *named, *wrong]


def machines_of(robot: RobotDescription) -> dict[str, RobotDescription]:
    """The robot without one of the things that limit the law; each is its own model."""
    drive, servo = robot.drive, robot.servo
    strong = replace(robot, drive=replace(drive, peak_torque=2 * drive.peak_torque))
    return {
        "as it is": robot,
        "without gravity": replace(robot, gravity=np.zeros(3)),
        "physics at a quarter of its step": replace(robot, physics_dt=robot.physics_dt / 4),
        "twice the peak torque": strong,
        "and half the control step": replace(strong, servo=replace(servo, control_dt=servo.control_dt / 2)),
    }


def model(
    robot: str = "irb4600_60_205",
    effects: Sequence[str] = tuple(EFFECTS),
    share: float = 0.7,
    positions: Sequence[str] = ("p2",),
    speeds: Sequence[float] = SPEEDS,
    radii: Sequence[float] = (0.001, 0.003),
) -> Contents:
    """Compare feed-forward from a machine's own model with none, for each effect: mean RMS path error [um].

    Effects are put on the robot that the controller knows, one at a time, at a share of the strongest plausible size;
    those that no torque compensates are left out.
    """
    arm = RigidArm(load_robot(robot))
    rows = []
    for name in effects:
        machine = Machine(robot=arm.robot, effects=(strong(EFFECTS[name], arm.robot, share),), climate=WARM)
        if not left_alone(machine):
            laws = [elastic_law(arm), model_law(machine, arm)]
            rig = SimulatedRig(arm=arm, machine=machine)
            study = circle_study(rig, laws=laws, positions=positions, speeds=speeds, radii=radii)
            pairs = zip(*(_mean_rms(study, law, speeds) for law in laws), strict=True)
            rows.append((f"`{name}`", *(f"{error * 1e3:.1f}" for pair in pairs for error in pair)))
    heads = [f"{law}, {speed * 1e3:g} mm/s" for speed in speeds for law in ("elastic", "model")]
    return Contents(parts={"effects": markdown(("effect", *heads), rows)})


def strong(effect: type[Effect], robot: RobotDescription, share: float) -> Effect:
    """The effect on all joints, a share of the way to the farther end of each parameter's plausible range.

    Friction behind the elasticity is put on the first three joints alone: the last link of the built-in robot is so
    light that bristles which move with it need a physics step shorter than 0.25 ms.
    """
    values: dict[str, Any] = {}
    for name, known in effect.parameters().items():
        if known.null is not None:
            far = max((known.low, known.high), key=lambda end: abs(end - known.neutral))
            size = known.neutral + share * (far - known.neutral)
            values[name] = size * (1 - np.eye(robot.n_joints)) if known.per == "pair" else size
    if effect is EFFECTS["arm_friction"]:
        values = {name: np.where(np.arange(robot.n_joints) < 3, size, 0.0) for name, size in values.items()}
    return effect.on(robot, **values)


def _compare(
    what: str,
    cases: Mapping[str, tuple[RobotDescription, FeedForwardLaw]],
    positions: Sequence[str] | None,
    speeds: Sequence[float],
    radii: Sequence[float],
) -> str:
    """Tabulate the mean RMS path error [mm] of a law on a robot, for each case, speed by speed."""
    table = []
    for name, (each, law) in cases.items():
        study = circle_study(each, laws=[law], positions=positions, speeds=speeds, radii=radii)
        table.append((name, *(f"{error:.4f}" for error in _mean_rms(study, law, speeds))))
    return markdown((what, *_heads(speeds)), table)


def _heads(speeds: Sequence[float]) -> tuple[str, ...]:
    """Headings of columns by speed."""
    return tuple(f"{speed * 1e3:g} mm/s" for speed in speeds)


def _mean_rms(study: CircleStudy, law: FeedForwardLaw, speeds: Sequence[float]) -> list[float]:
    """Mean RMS path error of a law [mm], speed by speed."""
    cells = [study.select(agent=law.name, speed_mm_s=round(speed * 1e3, 6)) for speed in speeds]
    return [float(np.mean([cell.rms_mm for cell in each])) for each in cells]
