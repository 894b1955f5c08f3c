"""`ffgym robot fill`: numbers that follow from others by rules of thumb, put into the description."""

from dataclasses import dataclass
from pathlib import Path

import tyro

from ffgym.core.errors import FFGymError
from ffgym.core.files import check_writable, read_text, write_text
from ffgym.robot import load_draft
from ffgym.robot.reading.parse import parse_draft
from ffgym.robot.template import filled_text, propose


@dataclass(frozen=True)
class Fill:
    """Fill in what a description lacks and what follows from the rest by rules of thumb; say which."""

    robot: tyro.conf.Positional[Path]
    """Description, .toml; it is written again, with all that is in it."""

    def run(self) -> None:
        """Propose, write, print."""
        if self.robot.suffix != ".toml":
            raise FFGymError(f"{self.robot} must be a description that ends in .toml; built-in robots are whole.")
        draft = load_draft(self.robot)
        check_writable(self.robot)
        proposals = propose(draft)
        if proposals:
            text = filled_text(read_text(self.robot), proposals, draft.types)
            draft = parse_draft(text, where=str(self.robot), folder=self.robot.parent)
            write_text(self.robot, text)
        for proposal in proposals:
            print(f"{proposal.path}: {proposal.source}")
        missing = f"missing: {', '.join(draft.missing)}" if draft.missing else "nothing is missing"
        print(f"{len(proposals)} {'entry' if len(proposals) == 1 else 'entries'} filled in; {missing}")
