"""`ffgym leaderboard submit` and `verify`: an agent as a submission to the leaderboard, packed and checked."""

from collections.abc import Sequence
from dataclasses import asdict, fields, replace
from typing import Any

from ffgym.agents.submission import LOADERS, resolve_agent, rows_beside
from ffgym.cli.learning_options import NewRound, Submit, Verify
from ffgym.cli.outputs import claim_outputs, print_places, provenance, write_numbers
from ffgym.cli.progress import progress_bar
from ffgym.control.observation import Channel
from ffgym.core.errors import FFGymError
from ffgym.core.files import write_bytes, write_json
from ffgym.core.typed_json import to_json
from ffgym.leaderboard.plants import ROBOT
from ffgym.leaderboard.results import CHANNEL_TITLES, FEED_FORWARD, WITH_FEEDBACK
from ffgym.leaderboard.submission.drawn import BASE, DrawnVerdict, verify_drawn
from ffgym.leaderboard.submission.judge import CHECKS, Judge, controller_of
from ffgym.leaderboard.submission.manifest import About, Claim, Refused, read_archive
from ffgym.leaderboard.submission.process import describe_isolation, isolation_note
from ffgym.leaderboard.submission.rounds import Round, draw_round, read_commitment, read_round
from ffgym.robot import load_robot


def submit(config: Submit) -> None:
    """Check, run, pack, print."""
    inputs = (config.agent, config.agent.partition(":")[2])
    claim_outputs({"--out": config.out, "--json": config.json}, inputs=inputs, suffix=".zip")
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
    claim_outputs({"--json": config.json}, inputs=(config.submission, config.round, config.committed))
    drawn = find_round(config)
    others = [read_archive(name) for name in config.beside if name.endswith(".zip")]
    names = tuple(dict.fromkeys((BASE, *(name for name in config.beside if not name.endswith(".zip")))))
    beside = {} if drawn is None else rows_beside(names, load_robot(controller_of(drawn.plants[0])))
    info = provenance("ffgym leaderboard verify", config, ROBOT, None, None if drawn is None else drawn.seed)
    info["isolation"] = describe_isolation()
    scored = None
    try:
        data = read_archive(config.submission)
        if (note := isolation_note()) is not None:
            print(note)
        judge = Judge(loaders=LOADERS, n_threads=config.threads, stage=progress_bar)
        verdict = judge.verify(data)
        if drawn is not None:
            scored = verify_drawn(judge, data, drawn, beside, others)
    except Refused as refusal:
        write_numbers(config, info | {"accepted": False, "check": refusal.check, "reason": refusal.reason})
        raise FFGymError(f"{config.submission}: {refusal}") from refusal
    own = verdict.manifest
    sentence = "accepted, without a score: no machines were drawn" if scored is None else scored.sentence
    found = {
        "accepted": True,
        "verdict": sentence,
        "inference_us": verdict.inference_us,
        "action_difference": verdict.action_difference,
        "claims": [asdict(claim) for claim in verdict.claims],
        "manifest": own.tree(),
        "drawn": None if scored is None else _drawn_numbers(scored),
    }
    write_numbers(config, info | found)
    for check, what in CHECKS.items():
        print(f"{check}: {what}")
    print("\n".join(claim_lines(verdict.claims)))
    print(f"one decision: {verdict.inference_us:.0f} us")
    if scored is not None:
        print("\n".join(_drawn_lines(scored)))
    control = WITH_FEEDBACK if own.sees_errors else FEED_FORWARD
    print(f"{own.name} by {own.author}, {control}{_through(own.channel)}, {own.track}: {sentence}")
    print_places(numbers=config.json)


def new_round(config: NewRound) -> None:
    """Draw, write, print; a round whose secret is there already is kept, as nobody could restore it."""
    claim_outputs({"--out": config.out, "--secret": config.secret})
    drawn = draw_round(machines=config.machines, motions=config.motions, series=config.series, kinds=config.kinds)
    if config.secret.exists():
        drawn = _keep_round(config, drawn)
    else:
        write_json(config.secret, drawn.list_revealed())
    write_json(config.out, drawn.list_published())
    print(f"commitment: {drawn.commitment}")
    print(f"publish now: {config.out}")
    print(f"publish after the round, and keep to yourself until then: {config.secret}")


def _keep_round(config: NewRound, drawn: Round) -> Round:
    """Read the round that was drawn before in place of a new one, which must differ by its seed alone."""
    kept = read_round(config.secret)
    if replace(drawn, seed=kept.seed, salt=kept.salt) != kept:
        raise FFGymError(
            f"--secret {config.secret}: holds the seed of a round of other machines or motions. Choose another file "
            f"for the new round, or move this one away."
        )
    print(f"{config.secret} holds a round, which is kept; to draw another, choose another --secret")
    return kept


def find_round(config: Verify) -> Round | None:
    """Find the round of a verification: revealed, repeated by its seed, or drawn now; None without machines."""
    if config.committed is not None and config.round is None:
        raise FFGymError("--committed needs the revealed round that it is compared with: --round FILE.")
    if config.round is not None:
        if config.round_seed is not None:
            raise FFGymError("--round and --round-seed both give a seed; leave one of them out.")
        drawn = read_round(config.round)
        if config.committed is not None and read_commitment(config.committed) != drawn.commitment:
            raise FFGymError(
                f"--round {config.round}: is the round {drawn.commitment}, not the one that was committed to in "
                f"{config.committed}, {read_commitment(config.committed)}."
            )
        return drawn
    if config.machines == 0:
        return None
    drawn = draw_round(machines=config.machines, motions=config.motions, series=config.series, kinds=config.kinds)
    return drawn if config.round_seed is None else replace(drawn, seed=config.round_seed, salt="")


def _through(channel: Channel) -> str:
    """Name a channel other than torque, after a track."""
    return "" if channel == "torque" else f" through {CHANNEL_TITLES[channel]}"


def _drawn_numbers(scored: DrawnVerdict) -> dict[str, Any]:
    """Convert scores on drawn machines and motions to JSON."""
    return {
        "round": scored.round.list_revealed(),
        "plants": dict(scored.fingerprints),
        "motions": to_json(scored.motions),
        "rows": [
            {"name": row.name, "rank": row.rank, "feedback": row.row.feedback, "public": row.public}
            | {"channel": row.row.channel, "by_kind": dict(row.by_kind)}
            | {"score": to_json(row.score)}
            | {"circles": [{"plant": o.plant} | to_json(cell) for o in row.row.outcomes for cell in o.cells]}
            for row in scored.rows
        ],
        "against_base": to_json(scored.against_base),
        "public_against_base": scored.public_ratio,
        "memorised": scored.is_memorised,
        "robot_seconds_counted": scored.robot_seconds,
        "robot_seconds_claimed": scored.manifest.robot_seconds,
    }


def _drawn_lines(scored: DrawnVerdict) -> list[str]:
    """Error left on drawn machines and motions as a table, with the draw and robot time."""
    drawn = scored.round
    lines = [
        f"round: seed {drawn.seed}, {drawn.machines} machines {drawn.series}<number>, {drawn.motions} motions "
        f"(repeat with --round-seed {drawn.seed} --machines {drawn.machines} --motions {drawn.motions} "
        f"--series {drawn.series} --kinds {' '.join(drawn.kinds)})",
        f"{'error left':20} {'drawn':>7} {'interval':>16} {'public':>7} {'rank':>5} track",
    ]
    for row in scored.rows:
        ends = row.score.left_interval
        interval = "" if ends is None else f"{ends.low:.3f} to {ends.high:.3f}"
        lines.append(
            f"{row.name:20} {row.score.left:7.3f} {interval:>16} {row.public:7.3f} {row.rank:5d} {row.row.control}"
            f"{_through(row.row.channel)}"
        )
    kinds = list(scored.rows[0].by_kind)
    lines.append(f"{'by kind of motion':20}" + "".join(f" {kind:>7}" for kind in kinds))
    lines += [f"{row.name:20}" + "".join(f" {row.by_kind[kind]:7.3f}" for kind in kinds) for row in scored.rows]
    return [
        *lines,
        f"robot time: {scored.robot_seconds:g} s before the scored motions, as counted here; "
        f"{scored.manifest.robot_seconds:g} s in training, as claimed",
    ]


def claim_lines(claims: Sequence[Claim]) -> list[str]:
    """Errors as a table."""
    head = f"{'plant':16} {'position':8} {'r [mm]':>7} {'v [mm/s]':>9} {'RMS [mm]':>9} {'max [mm]':>9}"
    rows = [
        f"{claim.plant:16} {claim.position:8} {claim.radius_mm:7g} {claim.speed_mm_s:9g} "
        f"{claim.rms_mm:9.4f} {claim.max_mm:9.4f}"
        for claim in claims
    ]
    return [head, *rows]
