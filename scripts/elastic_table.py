"""What elastic feed-forward is worth, with a wrong model, and what limits it: the tables of docs/agents/elastic.md.

`python -m scripts.elastic_table` prints the tables and renews them in the page, in about a minute.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ffgym.agents import dynamic_lugre
from ffgym.agents.elastic import ElasticLaw, elastic_feedforward, elastic_law
from ffgym.control import FeedForwardLaw
from ffgym.robot import RigidArm, RobotDescription, load_robot
from ffgym.studies import circle_study
from scripts.convergence_table import renewed

PAGE = Path(__file__).parents[1] / "docs" / "agents" / "elastic.md"


@dataclass(frozen=True)
class Config:
    """What to compute."""

    robot: str = "irb4600_60_205"
    """The simulated robot, and the model that is made wrong."""
    positions: tuple[str, ...] | None = None
    """Positions of the circles; None takes all."""
    speeds: tuple[float, ...] = (0.010, 0.040, 0.100)
    """TCP speeds [m/s]."""
    radii: tuple[float, ...] = (0.001, 0.003, 0.005)
    """Circle radii [m]."""
    write: Path | None = PAGE
    """Markdown file whose marked tables are replaced; None only prints."""


def main(config: Config) -> dict[str, str]:
    """Compute both tables; returns them as Markdown by name."""
    robot = load_robot(config.robot)
    laws = _table("law", {law.name: (robot, law) for law in laws_of(robot)}, config)
    machines = {name: (machine, elastic_feedforward(machine)) for name, machine in machines_of(robot).items()}
    tables = {"laws": laws, "machines": _table("machine", machines, config)}
    for table in tables.values():
        print(table, end="\n\n")
    if config.write is not None:
        config.write.write_text(renewed(config.write.read_text(encoding="utf-8"), tables), encoding="utf-8")
    return tables


def laws_of(robot: RobotDescription) -> list[FeedForwardLaw]:
    """Dynamic LuGre, and elastic feed-forward whole, in parts and wrong; named as in the table."""
    law, arm = elastic_feedforward(robot), RigidArm(robot)
    springs = elastic_feedforward(robot, compensate_friction=False)
    named: list[FeedForwardLaw] = [replace(springs, name="springs without friction")]
    named += [replace(law, preview=preview, name=f"{preview} samples ahead") for preview in (3, 5)]
    return [dynamic_lugre(robot), law, *named, *_wrong(robot, arm)]


def _wrong(robot: RobotDescription, arm: RigidArm) -> list[ElasticLaw]:
    """The law with parameters that are off by as much as one may expect; the controller is the robot's own."""
    drive, bodies = robot.drive, robot.bodies
    models = {}
    for percent in (-20, -10, 10, 20):
        factor = 1 + percent / 100
        springs = {"joint_stiffness": drive.joint_stiffness * factor, "joint_damping": drive.joint_damping * factor}
        models[f"stiffness {percent:+d} %"] = replace(robot, drive=replace(drive, **springs))
    for percent in (-30, 30):
        factor = 1 + percent / 100
        friction = robot.friction.scaled(coulomb=factor, static=factor, viscous=factor)
        models[f"friction {percent:+d} %"] = replace(robot, friction=friction)
    for percent in (-5, 5):
        factor = 1 + percent / 100
        links = replace(bodies, mass=bodies.mass * factor, inertia=bodies.inertia * factor)
        models[f"link masses {percent:+d} %"] = replace(robot, bodies=links)
    return [elastic_law(RigidArm(model), arm, name) for name, model in models.items()]


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


def _table(head: str, rows: Mapping[str, tuple[RobotDescription, FeedForwardLaw]], config: Config) -> str:
    """Mean RMS path error of each law on its robot [mm]."""
    lines = [f"| {head} | " + " | ".join(f"{v * 1e3:g} mm/s" for v in config.speeds) + " |"]
    lines.append("|---" * (len(config.speeds) + 1) + "|")
    for name, (robot, law) in rows.items():
        study = circle_study(robot, laws=[law], positions=config.positions, speeds=config.speeds, radii=config.radii)
        each = [study.select(speed_mm_s=round(speed * 1e3, 6)) for speed in config.speeds]
        means = [np.mean([cell.rms_mm for cell in cells]) for cells in each]
        lines.append(f"| {name} | " + " | ".join(f"{mean:.4f}" for mean in means) + " |")
    return "\n".join(lines)


if __name__ == "__main__":
    import tyro

    main(tyro.cli(Config))
