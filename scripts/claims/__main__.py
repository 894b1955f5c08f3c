"""`python -m scripts.claims`: every number of the documentation, and whether it still holds."""

import subprocess
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from ffgym.cli.main import run_command
from ffgym.core.errors import FFGymError
from ffgym.core.files import check_writable, made_folder, write_json
from ffgym.core.provenance import versions
from scripts.claims.history import keep_made
from scripts.claims.page import ROOT, pages
from scripts.claims.records import FOLDER, make_record, records_in
from scripts.claims.report import count, count_all, describe, list_untraced
from scripts.claims.steps import Made, choose_steps, every_step, run_steps
from scripts.claims.trace import Fault, Trace, check_pages


@dataclass(frozen=True)
class CheckClaims:
    """Make every number of README and docs again; print those that do not hold, and what each is traced by."""

    short: bool = False
    """Compare with stored results alone, in seconds; simulate and test nothing."""
    out: Path = Path("out/claims")
    """Folder of what was made; an interrupted call goes on there."""
    json: Path | None = None
    """Also write every number with its trace, and what does not hold, to this file."""
    steps: tuple[str, ...] = ()
    """Steps to make again by name, as 'tests/*' or 'page narx.md'; none given is all."""
    keep: bool = False
    """Also keep in docs/records/claims.json what was made, for the table of docs/claims.md."""
    record: tuple[str, ...] = ()
    """Records of docs/records to make and store; nothing else is done."""

    def run(self) -> None:
        """Trace, make again, print.

        Raises:
            FFGymError: if a number does not hold.
        """
        if self.json is not None:
            check_writable(self.json)
        if self.record:
            for name in self.record:
                print(f"stored {make_record(name, FOLDER).relative_to(ROOT)}")
            return
        made, began = list[Made](), time.monotonic()
        if not self.short:
            chosen = choose_steps(every_step(self.out), self.steps)
            with made_folder(self.out):
                for one in run_steps(chosen, self.out, _state()):
                    print(f"{one.name}: {one.skipped or 'made'}, {one.seconds:.0f} s", flush=True)
                    made.append(one)
        with records_in(self.out if not self.short else FOLDER):
            traces, faults = check_pages(pages())
        every = [*faults, *(fault for one in made for fault in one.faults), *list_untraced(traces)]
        print(describe(traces))
        print("\n".join(map(str, every)) or "All numbers that are traced hold.")
        print(
            f"{time.monotonic() - began:.0f} s; all that was made again took {sum(one.seconds for one in made):.0f} s"
        )
        if self.json is not None:
            write_json(self.json, _document(traces, every, made))
        if self.keep:
            others = len(every) - sum(len(one.faults) for one in made)
            keep_made(made, every_step(self.out), count_all(traces) | {"faults": others})
        if every:
            raise FFGymError(
                f"{len(every)} numbers of the documentation do not hold, or marks lead nowhere; see above."
            )


def _document(traces: list[Trace], faults: list[Fault], made: list[Made]) -> dict[str, object]:
    return {
        "versions": versions(),
        "pages": count(traces),
        "numbers": {trace.page: [asdict(each) for each in trace.numerals] for trace in traces},
        "faults": [asdict(fault) for fault in faults],
        "made_again": [asdict(one) for one in made],
    }


def _state() -> str:
    """Name the state of the code: what was made by other code is made again."""
    changed = _git("stash", "create") or "HEAD"
    return " ".join(_git("rev-parse", f"{changed}:{folder}") for folder in ("ffgym", "agents", "scripts", "tests"))


def _git(*arguments: str) -> str:
    call = ["git", *arguments]
    return subprocess.run(call, cwd=ROOT, check=False, capture_output=True, text=True).stdout.strip()


if __name__ == "__main__":
    sys.exit(run_command(CheckClaims, "python -m scripts.claims"))
