"""`python -m scripts.fuzz`: damaged files for every reader, and what comes of them."""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from tempfile import TemporaryDirectory

from ffgym.cli.main import run_command
from ffgym.cli.outputs import claim_outputs, provenance
from ffgym.cli.progress import progress_bar
from ffgym.core.claims import claimed
from ffgym.core.errors import FFGymError, check_choice, check_whole
from ffgym.core.files import check_vacant, made_folder, write_json
from scripts.fuzz.groups import load_readers, share_inputs
from scripts.fuzz.outcome import Outcome
from scripts.fuzz.reader import Reader, damage, make_valid
from scripts.fuzz.tally import Count, Tally, load_tally, save_tally, tally_table
from scripts.fuzz.watch import Watched

_MOST = 10_000_000
"""Most inputs; more are surely a slip."""
_SAVED = 200
"""Inputs after which the counts are written."""


@dataclass(frozen=True)
class Fuzz:
    """Damage valid files of every reader by seed, read them, and list what is neither a result nor one clear error."""

    readers: tuple[str, ...] = ()
    """Readers by name; none given is all."""
    inputs: int = 5000
    """Inputs of all readers together, shared so that fast readers get more."""
    seed: int = 1
    """Seed of the damage."""
    only: int | None = None
    """Number of the one input to read, as a finding names it."""
    keep: Path | None = None
    """Folder that must not exist, for the damaged files of that input."""
    out: Path | None = None
    """Folder for counts and findings; a run that was interrupted goes on there."""
    json: Path | None = None
    """Also write counts and findings to this file."""

    def run(self) -> None:
        """Check, read, print; findings are an error."""
        check_whole("--inputs", self.inputs, low=1, high=_MOST)
        check_whole("--seed", self.seed, low=0)
        claim_outputs({"--json": self.json})
        chosen = self._chosen()
        if self.only is not None:
            self._read_one(chosen, check_whole("--only", self.only, low=0))
            return
        if self.keep is not None:
            raise FFGymError("--keep has no effect without --only. Leave it out, or name an input.")
        tally = self._read_all(chosen)
        print(tally_table(tally.counts).text())
        for finding in tally.findings:
            print(f"\n{finding['kind']} {finding['place']}\n  {finding['detail']}\n  {finding['again']}")
        if self.json is not None:
            write_json(self.json, provenance("python -m scripts.fuzz", self, "", None, self.seed) | tally.document())
        if tally.findings:
            raise FFGymError(f"{len(tally.findings)} inputs ended neither in a result nor in one clear error.")

    def _chosen(self) -> list[tuple[str, Reader]]:
        """Readers that are asked for, each with its group."""
        every = {one.name: (group, one) for group, readers in load_readers().items() for one in readers}
        for name in self.readers:
            check_choice("reader", name, list(every))
        return [every[name] for name in self.readers or every]

    def _read_one(self, chosen: Sequence[tuple[str, Reader]], number: int) -> None:
        if len(chosen) != 1:
            raise FFGymError("--only needs one reader. Name it with --readers.")
        ((group, reader),) = chosen
        if self.keep is not None:
            check_vacant(self.keep)
            with TemporaryDirectory() as folder:
                valid = make_valid(reader, Path(folder))
            found = damage(reader, valid, self.seed, number)
            valid[found.number].write(self.keep)
            found.write(self.keep)
            print(
                f"files: {self.keep}, of which {found.name} is damaged; the reader is given {valid[found.number].main}"
            )
        with Watched(group) as watched:
            outcome = watched.read(reader.name, self.seed, number)
        print(f"{outcome.kind} {outcome.place}\n{outcome.detail}")
        if not outcome.is_right:
            raise FFGymError(f"Input {number} of {reader.name} ends neither in a result nor in one clear error.")

    def _read_all(self, chosen: Sequence[tuple[str, Reader]]) -> Tally:
        """Read the inputs that are not counted yet."""
        if self.out is None:
            return self._go_on(chosen, Tally(seed=self.seed), None)
        with made_folder(self.out), claimed(self.out):
            return self._go_on(chosen, load_tally(self.out / "fuzz.json", self.seed), self.out)

    def _go_on(self, chosen: Sequence[tuple[str, Reader]], tally: Tally, out: Path | None) -> Tally:
        shares = share_inputs([reader for _, reader in chosen], self.inputs)
        total = sum(shares.values())
        done = sum(min(count.inputs, shares.get(name, 0)) for name, count in tally.counts.items())
        with progress_bar("reading", "inputs") as progress:
            for name, number, outcome in self._outcomes(chosen, shares, tally):
                found = tally.add(name, number, outcome)
                done += 1
                progress(done, total)
                if out is not None and found is not None:
                    write_json(out / f"{name}-{number}.json", found)
                if out is not None and (done % _SAVED == 0 or done == total):
                    save_tally(out / "fuzz.json", tally)
        return tally

    def _outcomes(
        self, chosen: Sequence[tuple[str, Reader]], shares: dict[str, int], tally: Tally
    ) -> Iterator[tuple[str, int, Outcome]]:
        """Read what is not counted yet, the readers of a group in one process."""
        for group, readers in groupby(chosen, key=lambda one: one[0]):
            with Watched(group) as watched:
                for _, reader in readers:
                    first = tally.counts.get(reader.name, Count()).inputs
                    for number in range(first, shares[reader.name]):
                        yield reader.name, number, watched.read(reader.name, self.seed, number)


def main(arguments: Sequence[str] | None = None) -> int:
    """Read damaged files with these arguments; the process' if None are given."""
    return run_command(Fuzz, "python -m scripts.fuzz", arguments)


if __name__ == "__main__":
    sys.exit(main())
