"""`ffgym submit`: an agent as a submission to the leaderboard, run and packed."""

from dataclasses import dataclass, fields
from pathlib import Path

import tyro

from ffgym.agents.submission import LOADERS, submitted
from ffgym.cli.outputs import check_outputs, provenance
from ffgym.cli.progress import progress_bar
from ffgym.cli.verify import claim_lines
from ffgym.core.errors import FFGymError
from ffgym.core.files import write_bytes, write_json
from ffgym.leaderboard.plants import ROBOT
from ffgym.leaderboard.submission.judge import Judge
from ffgym.leaderboard.submission.manifest import About, AgentSource, Track


@dataclass(frozen=True)
class Submit:
    """Run an agent where it sees observations only, and pack it with its logged actions and what came out."""

    agent: tyro.conf.Positional[str]
    """Law of docs/agents that needs no learning, model:machine.toml, a file .npz of a learned law or a residual policy,
    or a Python file of your own (docs/leaderboard/submissions.md)."""
    name: str
    """Short name, as in tables."""
    author: str
    """Who made it."""
    track: Track
    """What it may know, see docs/agents."""
    title: str | None = None
    """What it is, in a line; none is the name."""
    out: Path = Path("agent.zip")
    """File to write."""
    seed: int = 0
    """Of the agent's randomness and the sensors' noise."""
    env_steps: int = 0
    """Control steps of simulated training that it took; a claim that nobody can check."""
    robot_seconds: float = 0.0
    """Time that a machine moved while it learned; a claim that nobody can check."""
    inference_us: float | None = None
    """Time of one decision to claim; none claims nothing. It is measured when a submission is verified."""
    json: Path | None = None
    """Also write the manifest and where it comes from to this file."""
    threads: int = 0
    """Threads of the simulation, 0 for all cores; results are the same at any number."""

    def run(self) -> None:
        """Check, run, pack, print."""
        if self.out.suffix != ".zip":
            raise FFGymError(f"--out {self.out}: the name must end in .zip.")
        check_outputs({"--out": self.out, "--json": self.json}, inputs=(self.agent, self.agent.partition(":")[2]))
        source = submitted(self.agent)
        said = {field.name: getattr(self, field.name) for field in fields(About)}
        about = About(**said | {"title": self.title or self.name})
        judge = Judge(loaders=LOADERS, n_threads=self.threads, stage=progress_bar)
        packed = judge.pack(about, AgentSource(kind=source.kind, law=source.law, file=source.file), source.content)
        write_bytes(self.out, packed.data)
        if self.json is not None:
            info = provenance("ffgym submit", self, ROBOT, None, self.seed)
            measured = {"inference_us_measured": packed.inference_us}
            write_json(self.json, info | measured | {"manifest": packed.manifest.tree()})
        lines = [
            *claim_lines(packed.manifest.claims),
            f"one decision: {packed.inference_us:.0f} us",
            f"file: {self.out}",
        ]
        print("\n".join(lines))
        if self.json is not None:
            print(f"numbers: {self.json}")
