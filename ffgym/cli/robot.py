"""`ffgym robot`: descriptions of robots, from an arm file to what is known, what is missing, and what works."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro

from ffgym.cli.outputs import check_outputs, need_extra, provenance
from ffgym.core.errors import FFGymError
from ffgym.core.files import check_writable, read_text, write_json, write_text
from ffgym.robot import ModelOptions, RobotDraft, compile_model, load_draft, physics_fingerprint
from ffgym.robot.arm_file import read_arm
from ffgym.robot.reading.parse import parse_draft
from ffgym.robot.template import filled_text, propose, template
from ffgym.studies.robot_check import RobotCheck, check_robot


@dataclass(frozen=True)
class New:
    """Write a commented table for the arm of an MJCF or URDF file: what is known, and a place for what is not."""

    arm: tyro.conf.Positional[Path]
    """MJCF (.xml) or URDF (.urdf) file."""
    out: Path = Path("my_robot.toml")
    """Description to write, .toml; its name is the robot's name."""
    joints: tuple[str, ...] = ()
    """Joints that move, from the base outwards; none given is all. Others, e.g. a gripper's, are held."""
    tool_frame: str | None = None
    """Frame of the last link (site, body or fixed link) that is tool0; none given takes one with a usual name."""
    looks: bool = True
    """Take shapes and meshes; with no-looks, missing meshes do not matter."""
    force: bool = False
    """Write over a file that is there."""

    def run(self) -> None:
        """Read the arm, write the table."""
        if self.out.suffix != ".toml":
            raise FFGymError(f"{self.out}: the suffix is {self.out.suffix!r}, a description must end in .toml.")
        if self.out.exists() and not self.force:
            raise FFGymError(f"{self.out} is there already, and may hold your work; --force writes over it.")
        check_writable(self.out)
        joints = self.joints or None
        arm = read_arm(self.arm, joints, looks=self.looks)
        model = Path(os.path.relpath(self.arm.resolve(), self.out.resolve().parent)).as_posix()
        text = template(self.out.stem, arm, model, joints=joints, tool_frame=self.tool_frame, looks=self.looks)
        draft = parse_draft(text, where=str(self.out), folder=self.out.parent)
        text = filled_text(text, propose(draft), draft.types)
        missing = parse_draft(text, where=str(self.out), folder=self.out.parent).missing
        write_text(self.out, text)
        print(f"wrote {self.out}: {len(arm.joints)} joints, {', '.join(arm.joints)}; missing: {', '.join(missing)}")
        for note in arm.notes:
            print(f"note: {note}")
        print(f"next: put numbers into {self.out} where '#?' waits for them, then ffgym robot fill {self.out}")


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
        from ffgym.report.robot.page import format_check

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


@dataclass(frozen=True)
class Robot:
    """Make a description of a robot from an arm file, fill it in, and see what it says."""

    task: (
        Annotated[New, tyro.conf.subcommand("new")]
        | Annotated[Fill, tyro.conf.subcommand("fill")]
        | Annotated[Check, tyro.conf.subcommand("check")]
    )

    def run(self) -> None:
        """Run the task."""
        self.task.run()
