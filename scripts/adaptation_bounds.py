"""Bounds of adaptation: elastic feed-forward with true numbers, all or some; `python -m scripts.adaptation_bounds`.

On machines that are drawn robots, all of whose numbers the law has, and on workcells, whose own equations it lacks. The
table shows which numbers are worth finding, and what a law of this form leaves at best.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from ffgym.agents.elastic import elastic_law
from ffgym.control import FeedForwardLaw, NoCompensation
from ffgym.core.files import check_writable, write_json
from ffgym.core.types import Array
from ffgym.leaderboard.adaptation.protocol import score, scored_motions
from ffgym.report import Table
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine
from ffgym.workcell.draws import SERIES, draw


def _stiffness(nominal: RobotDescription, true: RobotDescription) -> RobotDescription:
    own = true.drive
    drive = replace(nominal.drive, joint_stiffness=own.joint_stiffness, joint_damping=own.joint_damping)
    return replace(nominal, drive=drive)


def _masses(nominal: RobotDescription, true: RobotDescription) -> RobotDescription:
    drive = replace(nominal.drive, rotor_inertia=true.drive.rotor_inertia)
    return replace(nominal, bodies=true.bodies, tool=true.tool, drive=drive)


def _levels(nominal: RobotDescription, true: RobotDescription) -> RobotDescription:
    return replace(nominal, friction=replace(true.friction, arm_share=nominal.friction.arm_share))


Known = Callable[[RobotDescription, RobotDescription], RobotDescription]
"""Function from nominal and true robot to the one that a law knows."""

KNOWN: Mapping[str, Known] = MappingProxyType(
    {
        "nominal numbers": lambda nominal, true: nominal,
        "true friction": lambda nominal, true: replace(nominal, friction=true.friction),
        "true friction, nominal share on the arm": _levels,
        "true stiffness": _stiffness,
        "true masses and payload": _masses,
        "true friction and stiffness": lambda nominal, true: replace(_stiffness(nominal, true), friction=true.friction),
        "all true numbers": lambda nominal, true: true,
    }
)
"""What a law knows, by name."""


@dataclass(frozen=True)
class Config:
    """Machines to run."""

    seeds: tuple[int, ...] = (1, 2, 3, 4, 5, 6)
    """Seeds of workcells of the series 'drives', and of drawn robots; not those of a round."""
    threads: int = 0
    """Threads of the engine, 0 for all cores."""
    json: Path | None = None
    """Also write the error left [1] for each machine and motion to this file."""


def main(config: Config) -> None:
    """Run and print."""
    if config.json is not None:
        check_writable(config.json)
    cells = [draw(seed, "drives") for seed in config.seeds]
    arm = cells[0].arm
    kinds: dict[str, list[Machine]] = {
        "drawn robots": [Machine(robot=robot) for robot in draw_robots(arm, config.seeds)],
        "workcells": [cell.machine for cell in cells],
    }
    left = {title: errors_left(arm, machines, config) for title, machines in kinds.items()}
    for title, found in left.items():
        print(format_bounds(title, found))
    if config.json is not None:
        lists = {title: {name: values.tolist() for name, values in found.items()} for title, found in left.items()}
        write_json(config.json, lists)


def draw_robots(arm: RigidArm, seeds: Sequence[int]) -> list[RobotDescription]:
    """Draw robots around the controller's as the series 'drives' draws them, but without any effect."""
    _, numbers = SERIES["drives"]
    return [numbers.draw(arm.robot, np.random.default_rng(seed)) for seed in seeds]


def errors_left(arm: RigidArm, machines: Sequence[Machine], config: Config) -> dict[str, Array]:
    """Compute the error left of that without compensation, (B, M), for everything that a law may know."""
    none = errors(arm, [NoCompensation()] * len(machines), machines, config)
    left = {}
    for name, known in KNOWN.items():
        laws = [elastic_law(RigidArm(known(arm.robot, machine.robot)), arm) for machine in machines]
        left[name] = errors(arm, laws, machines, config) / none
    return left


def format_bounds(title: str, left: Mapping[str, Array]) -> str:
    """Format geometric means over machines and motions, those of machines, and the worst motion as Markdown."""
    rows = []
    for name, values in left.items():
        logs = np.log(values)
        each = np.exp(logs.mean(axis=1))
        between = f"{each.min():.1%} to {each.max():.1%}"
        rows.append((name, f"{np.exp(logs.mean()):.1%}", between, f"{np.exp(logs.max()):.0%}"))
    head = (f"{title}: elastic feed-forward with", "error left", "machines", "worst motion")
    return Table.of_rows(head, rows).markdown()


def errors(arm: RigidArm, laws: Sequence[FeedForwardLaw], machines: Sequence[Machine], config: Config) -> Array:
    """Compute RMS path errors [m] of a law for each machine on the scored motions, (B, M)."""
    motions = scored_motions(arm)
    runs = [Run(reference=motion, law=law) for law in laws for motion in motions]
    each = [machine for machine in machines for _ in motions]
    recordings = simulate(runs, arm=arm, machine=each, n_threads=config.threads)
    return np.array([score(recording) for recording in recordings]).reshape(len(machines), len(motions))


if __name__ == "__main__":
    import tyro

    main(tyro.cli(Config))
