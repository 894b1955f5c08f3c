"""`ffgym leaderboard submit` and `verify`: an agent as a submission to the leaderboard, packed and checked."""

from collections.abc import Sequence
from dataclasses import asdict, fields

from ffgym.agents.submission import LOADERS, resolve_agent
from ffgym.cli.learning_options import Submit, Verify
from ffgym.cli.outputs import check_outputs, print_places, provenance, write_numbers
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import FFGymError
from ffgym.core.files import write_bytes
from ffgym.leaderboard.plants import ROBOT
from ffgym.leaderboard.submission.judge import CHECKS, Judge
from ffgym.leaderboard.submission.manifest import About, Claim, Refused, read_archive
from ffgym.leaderboard.submission.process import isolation_note


def submit(config: Submit) -> None:
    """Check, run, pack, print."""
    inputs = (config.agent, config.agent.partition(":")[2])
    check_outputs({"--out": config.out, "--json": config.json}, inputs=inputs, suffix=".zip")
    source, content = resolve_agent(config.agent)
    said = {field.name: getattr(config, field.name) for field in fields(About)}
    about = About(**said | {"title": config.title or config.name})
    judge = Judge(loaders=LOADERS, n_threads=config.threads, stage=progress_bar)
    packed = judge.pack(about, source, content)
    write_bytes(config.out, packed.data)
    info = provenance("ffgym leaderboard submit", config, ROBOT, None, config.seed)
    measured = {"inference_us_measured": packed.inference_us}
    write_numbers(config, info | measured | {"manifest": packed.manifest.tree()})
    print("\n".join(claim_lines(packed.manifest.claims)))
    print(f"one decision: {packed.inference_us:.0f} us")
    print_places(file=config.out, numbers=config.json)


def verify(config: Verify) -> None:
    """Check, run, print."""
    check_outputs({"--json": config.json}, inputs=(config.submission,))
    info = provenance("ffgym leaderboard verify", config, ROBOT, None, None)
    try:
        data = read_archive(config.submission)
        if (note := isolation_note()) is not None:
            print(note)
        verdict = Judge(loaders=LOADERS, n_threads=config.threads, stage=progress_bar).verify(data)
    except Refused as refusal:
        write_numbers(config, info | {"accepted": False, "check": refusal.check, "reason": refusal.reason})
        raise FFGymError(f"{config.submission}: {refusal}") from refusal
    found = {
        "accepted": True,
        "inference_us": verdict.inference_us,
        "action_difference": verdict.action_difference,
        "claims": [asdict(claim) for claim in verdict.claims],
        "manifest": verdict.manifest.tree(),
    }
    write_numbers(config, info | found)
    own = verdict.manifest
    print(f"{own.name} by {own.author}, {own.track}: accepted")
    for check, what in CHECKS.items():
        print(f"{check}: {what}")
    print("\n".join(claim_lines(verdict.claims)))
    print(f"one decision: {verdict.inference_us:.0f} us")
    print_places(numbers=config.json)


def claim_lines(claims: Sequence[Claim]) -> list[str]:
    """Errors as a table."""
    head = f"{'plant':16} {'position':8} {'r [mm]':>7} {'v [mm/s]':>9} {'RMS [mm]':>9} {'max [mm]':>9}"
    rows = [
        f"{claim.plant:16} {claim.position:8} {claim.radius_mm:7g} {claim.speed_mm_s:9g} "
        f"{claim.rms_mm:9.4f} {claim.max_mm:9.4f}"
        for claim in claims
    ]
    return [head, *rows]
