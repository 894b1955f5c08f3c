"""What feed-forward from a machine's own model gives back of what each effect takes: the table of docs/agents/model.md.

`python -m scripts.model_table` prints the table and renews it in the page, in about three minutes.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.agents.elastic import elastic_law
from ffgym.agents.model import left_alone, model_law
from ffgym.effects import EFFECTS, Effect
from ffgym.robot import RigidArm, RobotDescription, load_robot
from ffgym.simulation import SimulatedRig
from ffgym.simulation.plant import Climate, Machine
from ffgym.studies import CircleStudy, circle_study
from scripts.convergence_table import renewed

PAGE = Path(__file__).parents[1] / "docs" / "agents" / "model.md"
WARM = Climate(ambient=20.0, rise=np.array([25.0]), running_since=3600.0)
"""Climate of the machines, so that effects of temperature and time show."""


@dataclass(frozen=True)
class Config:
    """What to compute."""

    robot: str = "irb4600_60_205"
    """The nominal robot, which the controller knows."""
    effects: tuple[str, ...] = tuple(EFFECTS)
    """Effects to put on it, one at a time; those that no torque compensates are left out."""
    share: float = 0.7
    """Of the strongest plausible size."""
    positions: tuple[str, ...] = ("p2",)
    """Positions of the circles."""
    speeds: tuple[float, ...] = (0.010, 0.040, 0.100)
    """TCP speeds [m/s]."""
    radii: tuple[float, ...] = (0.001, 0.003)
    """Circle radii [m]."""
    write: Path | None = PAGE
    """Markdown file whose marked table is replaced; None only prints."""


def main(config: Config) -> str:
    """Compute the table; returns it as Markdown."""
    arm = RigidArm(load_robot(config.robot))
    heads = [f"{law}, {speed * 1e3:g} mm/s" for speed in config.speeds for law in ("elastic", "model")]
    lines = ["| effect | " + " | ".join(heads) + " |", "|---" * (len(heads) + 1) + "|"]
    for name in config.effects:
        machine = Machine(robot=arm.robot, effects=(strong(EFFECTS[name], arm.robot, config.share),), climate=WARM)
        if not left_alone(machine):
            errors = [f"{error:.1f}" for error in _errors(_circles(arm, machine, config), config)]
            lines.append(f"| `{name}` | " + " | ".join(errors) + " |")
    table = "\n".join(lines)
    print(table)
    if config.write is not None:
        config.write.write_text(renewed(config.write.read_text(encoding="utf-8"), {"effects": table}), encoding="utf-8")
    return table


def strong(effect: type[Effect], robot: RobotDescription, share: float) -> Effect:
    """The effect on all joints, a share of the way to the farther end of each parameter's plausible range."""
    values: dict[str, Any] = {}
    for name, known in effect.parameters().items():
        if known.null is not None:
            far = max((known.low, known.high), key=lambda end: abs(end - known.neutral))
            size = known.neutral + share * (far - known.neutral)
            values[name] = size * (1 - np.eye(robot.n_joints)) if known.per == "pair" else size
    return effect.on(robot, **values)


def _circles(arm: RigidArm, machine: Machine, config: Config) -> CircleStudy:
    rig = SimulatedRig(arm=arm, machine=machine)
    laws = [elastic_law(arm), model_law(machine, arm)]
    return circle_study(rig, laws=laws, positions=config.positions, speeds=config.speeds, radii=config.radii)


def _errors(study: CircleStudy, config: Config) -> list[float]:
    """Mean RMS path error [um], speed by speed, of both laws."""
    return [
        float(np.mean([cell.rms_mm for cell in study.select(agent=law, speed_mm_s=round(speed * 1e3, 6))])) * 1e3
        for speed in config.speeds
        for law in ("elastic", "model")
    ]


if __name__ == "__main__":
    import tyro

    main(tyro.cli(Config))
