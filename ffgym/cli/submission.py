"""`ffgym leaderboard submit` and `verify`: an agent as a submission to the leaderboard, packed and checked."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import tyro

from ffgym.agents.submission import LOADERS, submitted
from ffgym.cli.outputs import check_outputs, provenance
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import FFGymError
from ffgym.core.files import write_bytes, write_json
from ffgym.leaderboard.plants import ROBOT
from ffgym.leaderboard.submission.judge import CHECKS, Judge
from ffgym.leaderboard.submission.manifest import About, AgentSource, Claim, Refused, Track, read_archive
from ffgym.leaderboard.submission.process import isolation_note


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
            info = provenance("ffgym leaderboard submit", self, ROBOT, None, self.seed)
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


@dataclass(frozen=True)
class Verify:
    """Check a submission: replay its actions, while its agent is asked for them where it sees observations only.

    Bubblewrap isolates foreign code if it is installed; docs/leaderboard/submissions.md has a container for others.
    """

    submission: tyro.conf.Positional[Path]
    """File of ffgym leaderboard submit."""
    json: Path | None = None
    """Also write the verdict to this file, accepted or refused."""
    threads: int = 0
    """Threads of the simulation, 0 for all cores; results are the same at any number."""

    def run(self) -> None:
        """Check, run, print."""
        check_outputs({"--json": self.json}, inputs=(self.submission,))
        try:
            data = read_archive(self.submission)
            if (note := isolation_note()) is not None:
                print(note)
            verdict = Judge(loaders=LOADERS, n_threads=self.threads, stage=progress_bar).verify(data)
        except Refused as refusal:
            self._write({"accepted": False, "check": refusal.check, "reason": refusal.reason})
            raise FFGymError(f"{self.submission}: {refusal}") from refusal
        found = {
            "inference_us": verdict.inference_us,
            "action_difference": verdict.action_difference,
            "claims": [asdict(claim) for claim in verdict.claims],
        }
        self._write({"accepted": True} | found | {"manifest": verdict.manifest.tree()})
        own = verdict.manifest
        lines = [f"{own.name} by {own.author}, {own.track}: accepted"]
        lines += [f"{check}: {what}" for check, what in CHECKS.items()]
        lines += [*claim_lines(verdict.claims), f"one decision: {verdict.inference_us:.0f} us"]
        print("\n".join(lines))
        if self.json is not None:
            print(f"numbers: {self.json}")

    def _write(self, outcome: Mapping[str, Any]) -> None:
        if self.json is not None:
            write_json(self.json, provenance("ffgym leaderboard verify", self, ROBOT, None, None) | dict(outcome))


def claim_lines(claims: Sequence[Claim]) -> list[str]:
    """Errors as a table."""
    head = f"{'plant':16} {'position':8} {'r [mm]':>7} {'v [mm/s]':>9} {'RMS [mm]':>9} {'max [mm]':>9}"
    rows = [
        f"{claim.plant:16} {claim.position:8} {claim.radius_mm:7g} {claim.speed_mm_s:9g} "
        f"{claim.rms_mm:9.4f} {claim.max_mm:9.4f}"
        for claim in claims
    ]
    return [head, *rows]
