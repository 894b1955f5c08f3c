"""`ffgym verify`: whether a submission to the leaderboard is what it says."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import tyro

from ffgym.agents.submission import LOADERS
from ffgym.cli.outputs import check_outputs, provenance
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import FFGymError
from ffgym.core.files import write_json
from ffgym.leaderboard.plants import ROBOT
from ffgym.leaderboard.submission.judge import CHECKS, Judge
from ffgym.leaderboard.submission.manifest import Claim, Refused, read_archive
from ffgym.leaderboard.submission.process import isolation_note


@dataclass(frozen=True)
class Verify:
    """Check a submission: replay its actions, while its agent is asked for them where it sees observations only.

    Bubblewrap isolates foreign code if it is installed; docs/leaderboard/submissions.md has a container for others.
    """

    submission: tyro.conf.Positional[Path]
    """File of ffgym submit."""
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
            write_json(self.json, provenance("ffgym verify", self, ROBOT, None, None) | dict(outcome))


def claim_lines(claims: Sequence[Claim]) -> list[str]:
    """Errors as a table."""
    head = f"{'plant':16} {'position':8} {'r [mm]':>7} {'v [mm/s]':>9} {'RMS [mm]':>9} {'max [mm]':>9}"
    rows = [
        f"{claim.plant:16} {claim.position:8} {claim.radius_mm:7g} {claim.speed_mm_s:9g} "
        f"{claim.rms_mm:9.4f} {claim.max_mm:9.4f}"
        for claim in claims
    ]
    return [head, *rows]
