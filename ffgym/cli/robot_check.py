"""`ffgym robot check`: what a description says, lacks, allows and amounts to."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tyro

from ffgym.cli.outputs import check_outputs, need_extra, provenance
from ffgym.core.files import write_json, write_text
from ffgym.robot import ModelOptions, RobotDraft, compile_model, load_draft, physics_fingerprint
from ffgym.robot.template import propose
from ffgym.studies.robot_check import RobotCheck, check_robot


@dataclass(frozen=True)
class Check:
    """Print what is there, what is missing and what works; reach, resonances, loads, margins, and doubtful numbers."""

    robot: tyro.conf.Positional[str]
    """Built-in robot, or a path to a description that ends in .toml, complete or not."""
    report: Path | None = None
    """Page with pictures to write, .html, in one file that can be sent."""
    json: Path | None = None
    """Also write every number to this file."""

    def run(self) -> None:
        """Compute, write, print."""
        if self.report is not None:
            need_extra("The report", "matplotlib", "jinja2")
        check_outputs({"--report": self.report, "--json": self.json})
        draft = load_draft(self.robot)
        check = check_robot(draft)
        info = provenance("ffgym robot check", self, draft.name, _fingerprint(draft), None)
        if self.report is not None:
            from ffgym.report.robot.page import render_robot_page

            write_text(self.report, render_robot_page(check, info))
        if self.json is not None:
            write_json(self.json, info | _plain(check.numbers()))
        self._print(check)
        for what, place in (("report", self.report), ("numbers", self.json)):
            if place is not None:
                print(f"{what}: {place}")

    def _print(self, check: RobotCheck) -> None:
        from ffgym.report.robot.text import format_check

        print(format_check(check))
        proposals = [proposal.path for proposal in propose(check.draft)]
        if proposals:
            print(f"ffgym robot fill {self.robot} would fill in {', '.join(proposals)}.")


def _fingerprint(draft: RobotDraft) -> str | None:
    """Of the physics of a whole robot."""
    if draft.missing:
        return None
    return physics_fingerprint(compile_model(draft.complete(), ModelOptions(looks=False)))


def _plain(value: Any) -> Any:
    """A value as JSON has it."""
    if isinstance(value, dict):
        return {name: _plain(entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    return value.tolist() if isinstance(value, np.ndarray) else value
