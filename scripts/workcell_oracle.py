"""The oracle on a workcell, for the leaderboard: what a model without error is worth on that machine.

Only the workcell's package, environments, scripts and tests may know its truth, so that no command of ffgym can
run this row. `python -m scripts.workcell_oracle --out FOLDER` adds it to the row `oracle` of a folder that
`ffgym leaderboard --out FOLDER` writes; the truth itself is written nowhere. The row is shown, never ranked.
"""

from dataclasses import dataclass
from pathlib import Path

from ffgym.agents.entrants import REGISTRY
from ffgym.agents.law_agent import LawPolicy
from ffgym.agents.model import model_law
from ffgym.leaderboard.board import Board
from ffgym.leaderboard.entrants import ReadyAgent
from ffgym.leaderboard.evaluation.jobs import SeededAgent, run_agents
from ffgym.leaderboard.plants import THESIS_WORKCELL, find_plant
from ffgym.leaderboard.tasks import SPLITS
from ffgym.workcell import workcell


@dataclass(frozen=True)
class Config:
    """Machine, motions and place of the results."""

    out: Path
    """Folder of result files."""
    splits: tuple[str, ...] = SPLITS
    """Circles."""


def main(config: Config) -> None:
    """Run the oracle and keep its outcome."""
    plant = find_plant(THESIS_WORKCELL)
    truth = workcell(THESIS_WORKCELL.partition(":")[2])
    law = model_law(truth.machine, plant.rig.arm, name="oracle")
    acts = LawPolicy(make=lambda robot: law, preview=law.preview)
    starter = SeededAgent(name="oracle", seed=0, ready=ReadyAgent(law=law, timed=acts))
    board = Board(registry=REGISTRY, folder=config.out)
    with board.hold():
        board.keep(run_agents(plant, [starter], plant.tasks(config.splits)))


if __name__ == "__main__":
    import tyro

    main(tyro.cli(Config))
