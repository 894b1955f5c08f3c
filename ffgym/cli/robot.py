"""`ffgym robot`: descriptions of robots, from an arm file to what is known, what is missing, and what works."""

import os
from pathlib import Path

from ffgym.cli.log_options import CheckRobot, FillRobot, NewRobot
from ffgym.cli.outputs import claim_new, claim_outputs, print_places, provenance, write_numbers
from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text, write_text
from ffgym.report.robot.page import format_check, render_robot_page
from ffgym.robot import ModelOptions, compile_model, load_draft, physics_fingerprint
from ffgym.robot.arm_file import read_arm
from ffgym.robot.reading.parse import parse_draft
from ffgym.robot.template import fill_text, propose, template
from ffgym.studies.robot_check import check_robot


def new(config: NewRobot) -> None:
    """Read the arm, write the table."""
    out, joints = config.out, config.joints or None
    claim_new(out, "a description", force=config.force)
    claim_outputs({"--out": out}, inputs=(config.arm,))
    arm = read_arm(config.arm, joints, looks=config.looks)
    model = Path(os.path.relpath(config.arm.resolve(), out.resolve().parent)).as_posix()
    text = template(out.stem, arm, model, joints=joints, tool_frame=config.tool_frame, looks=config.looks)
    draft = parse_draft(text, where=str(out), folder=out.parent)
    text = fill_text(text, propose(draft), draft.types)
    missing = parse_draft(text, where=str(out), folder=out.parent).missing
    write_text(out, text)
    print(f"wrote {out}: {len(arm.joints)} joints, {', '.join(arm.joints)}; missing: {', '.join(missing)}")
    for note in arm.notes:
        print(f"note: {note}")
    print(f"next: put numbers into {out} where '#?' waits for them, then ffgym robot fill {out}")


def fill(config: FillRobot) -> None:
    """Propose, write, print."""
    if config.robot.suffix != ".toml":
        raise FFGymError(f"{config.robot} must be a description that ends in .toml; built-in robots are whole.")
    draft = load_draft(config.robot)
    claim_outputs({"ROBOT": config.robot})
    proposals = propose(draft)
    if proposals:
        text = fill_text(read_text(config.robot), proposals, draft.types)
        draft = parse_draft(text, where=str(config.robot), folder=config.robot.parent)
        write_text(config.robot, text)
    for proposal in proposals:
        print(f"{proposal.path}: {proposal.source}")
    missing = f"missing: {', '.join(draft.missing)}" if draft.missing else "nothing is missing"
    print(f"{len(proposals)} {'entry' if len(proposals) == 1 else 'entries'} filled in; {missing}")


def check(config: CheckRobot) -> None:
    """Compute, write, print."""
    claim_outputs({"--report": config.report, "--json": config.json}, inputs=(config.robot,))
    draft = load_draft(config.robot)
    result, fingerprint = check_robot(draft), None
    if not draft.missing:
        fingerprint = physics_fingerprint(compile_model(draft.complete(), ModelOptions(looks=False)))
    info = provenance("ffgym robot check", config, draft.name, fingerprint, None)
    if config.report is not None:
        write_text(config.report, render_robot_page(result, info))
    write_numbers(config, info | result.numbers())
    print(format_check(result))
    if proposals := [proposal.path for proposal in propose(result.draft)]:
        print(f"ffgym robot fill {config.robot} would fill in {', '.join(proposals)}.")
    print_places(report=config.report, numbers=config.json)
