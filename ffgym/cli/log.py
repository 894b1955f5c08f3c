"""`ffgym log`: logs of other tools: what a file holds, recordings of it, and what logs are good for."""

from dataclasses import asdict
from pathlib import Path
from typing import Any, get_args

from ffgym.cli.log_options import CheckLogs, ConvertLog, ListColumns
from ffgym.cli.outputs import (
    claim_new,
    claim_outputs,
    file_of_each,
    hash_inputs,
    print_places,
    provenance,
    write_numbers,
)
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import check_there, write_text
from ffgym.envs.machines import load_described_robot
from ffgym.logs import TextLayout, read_contents, read_logs
from ffgym.logs.draft import draft, listing
from ffgym.logs.entries import fitting_maps
from ffgym.logs.quality import QualityReport, check_quality
from ffgym.logs.quality.check import Overall
from ffgym.logs.quality.wiring import Mistake, find_wiring
from ffgym.recordings import Recording, write_recording
from ffgym.recordings.io import FORMATS, recording_files
from ffgym.report.quality import format_quality, render_quality_page
from ffgym.report.table import wrap_text
from ffgym.robot import RobotDescription, load_draft
from ffgym.simulation.plant.machine_file import is_machine_file


def columns(config: ListColumns) -> None:
    """List the arrays in a file; write a draft of a column map."""
    if config.out is not None:
        claim_new(config.out, "a column map", force=config.force)
    claim_outputs({"--out": config.out, "--json": config.json}, inputs=(config.log,))
    layout = TextLayout(
        delimiter=config.delimiter,
        decimal=config.decimal,
        encoding=config.encoding,
        names_row=config.names_row,
        units_row=config.units_row,
    )
    check_there(config.log)
    contents = read_contents(config.log, layout)
    maps = fitting_maps(contents)
    if config.out is not None:
        write_text(config.out, draft(contents, layout))
    arrays = [{"name": n, "shape": list(a.shape), "type": str(a.dtype)} for n, a in contents.arrays.items()]
    info = provenance("ffgym log columns", config, "", None, None)
    write_numbers(config, info | {"arrays": arrays, "skipped": dict(contents.skipped), "maps": maps})
    print("\n".join(listing(contents)))
    for name in maps:
        command = f"ffgym log convert {config.log} --columns {name} --robot ROBOT --out FILE.npz"
        print(f"built-in map: {name} fits: {command}")
    if config.out is None:
        print("next: ffgym log columns FILE --out map.toml writes a draft of a column map")
        return
    print(f"draft: {config.out}")
    print(f"next: fill in every '?', then ffgym log convert {config.log} --columns {config.out} --out recording.npz")


def convert(config: ConvertLog) -> None:
    """Make recordings of the motions in a file."""
    check_choice("recording format", config.out.suffix, list(FORMATS))
    inputs = (config.log, config.columns, config.robot)
    claim_outputs({"--out": config.out, "--json": config.json}, inputs=inputs)
    recordings = read_logs(config.log, config.columns, robot=config.robot)
    files = file_of_each(config.out, [recording.header.segment for recording in recordings])
    claim_outputs({f"--out of {segment}": place for segment, place in files.items()}, inputs=inputs)
    made = [(recording, files[recording.header.segment]) for recording in recordings]
    for recording, place in made:
        write_recording(recording, place)
    info = provenance("ffgym log convert", config, recordings[0].header.robot, None, None)
    write_numbers(config, info | {"recordings": [_numbers(recording, place) for recording, place in made]})
    for recording, place in made:
        header = recording.header
        span = f"{len(recording)} rows, {recording.t[-1] - recording.t[0]:.6g} s at {1 / recording.dt:.6g} Hz"
        print(f"{place}: {header.segment}, robot {header.robot}, {span}: {', '.join(recording.families)}")
    for name in recordings[0].header.provenance.get("left_out", []):
        print(f"note: {name} is left out, the file has nothing for it")
    print_places(numbers=config.json)


def _numbers(recording: Recording, place: Path) -> dict[str, Any]:
    return {
        "recording": str(place),
        "segment": recording.header.segment,
        "robot": recording.header.robot,
        "rows": len(recording),
        "start_s": float(recording.t[0]),
        "end_s": float(recording.t[-1]),
        "period_s": recording.dt,
        "columns": list(recording.columns),
        "source": recording.header.provenance,
    }


def check(config: CheckLogs) -> None:
    """Judge logs.

    Raises:
        FFGymError: at the end, if a log is insufficient.
    """
    if not config.logs:
        raise FFGymError("There is nothing to check: name at least one log.")
    inputs = (*config.logs, config.robot, config.columns)
    claim_outputs({"--report": config.report, "--json": config.json}, inputs=inputs)
    reports, wiring = _judge(config)
    info = provenance("ffgym log check", config, config.robot or "", None, None)
    info["inputs"] = hash_inputs((*config.logs, config.robot, config.columns))
    if config.report is not None:  # files first: printed text may go unread
        write_text(config.report, render_quality_page(reports, info))
    logs = [{"file": name} | report.numbers() for name, report in reports]
    write_numbers(config, info | {"logs": logs, "wiring": [asdict(mistake) for mistake in wiring]})
    for name, report in reports:
        print(f"{name}: {format_quality(report, figures=config.figures)}")
    verdicts = [report.verdict for _, report in reports]
    if len(reports) > 1:
        counts = [f"{verdicts.count(verdict)} {verdict}" for verdict in get_args(Overall)]
        print(f"{len(verdicts)} logs: {', '.join(counts)}.")
    for mistake in wiring:
        print(wrap_text(f"wiring of all logs: {mistake.message}"))
    print_places(report=config.report, numbers=config.json)
    if bad := [name for name, report in reports if report.verdict == "insufficient"]:
        raise FFGymError(f"Insufficient: {', '.join(bad)}; see above what is refused, and the way out.")
    if wiring:
        raise FFGymError(
            "Columns hold other signals than their names say, see above; `ffgym diagnose --out` writes a map."
        )


def _judge(config: CheckLogs) -> tuple[list[tuple[str, QualityReport]], tuple[Mistake, ...]]:
    """File names, each with the report of a motion in it; and what is wired wrongly in all logs together."""
    whose, robot = _describe(config.robot)
    # recordings in a folder are files of their own; with a column map, a folder may be one log
    files: list[str] = []
    for path in config.logs:
        is_folder = config.columns is None and Path(path).is_dir()
        files += map(str, recording_files(path)) if is_folder else [path]
    reports, read = [], []
    with progress_bar("checking", "logs") as progress:
        for done, path in enumerate(files):
            progress(done, len(files))
            recordings = read_logs(path, config.columns, robot=whose if config.columns else None)
            reports += [(path, check_quality(recording, robot, config.needs)) for recording in recordings]
            read += recordings if robot is not None else []
    wiring = find_wiring(read, robot).mistakes if robot is not None and len(read) > 1 else ()
    return reports, wiring


def _describe(name: str | None) -> tuple[RobotDescription | None, RobotDescription | None]:
    """The robot that logs are of, and the one to judge them by: None if its description lacks entries."""
    if name is None:
        return None, None
    if name.endswith(".toml") and not is_machine_file(name) and (known := load_draft(name)).missing:
        lacking = f"{known.missing[0]} and {len(known.missing) - 1} more" if known.missing[1:] else known.missing[0]
        print(f"note: {name} lacks {lacking}; nothing is judged that hangs on masses, ranges or limits")
        return known.description_for("kinematics", "drive.gear_ratio"), None
    robot = load_described_robot(name)
    return robot, robot
