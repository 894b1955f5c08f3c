"""`ffgym simulate`: any motion on any robot with any feed-forward laws: recordings, errors, pictures."""

from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from ffgym.cli.laws import check_laws, record_agents, refuse_with_policies, setting_for
from ffgym.cli.motion_options import Simulate
from ffgym.cli.outputs import claim_outputs, file_of_each, given_options, print_places, provenance, write_numbers
from ffgym.cli.program_motion import list_events, read_motion, tell_events
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import write_text
from ffgym.envs.machines import find_controller, is_workcell, make_rig
from ffgym.recordings import write_recording
from ffgym.recordings.io import FORMATS
from ffgym.report import format_motion, render_motion_page
from ffgym.robot import ModelOptions, RigidArm
from ffgym.simulation import Rig, SimulatedRig, sensors_of
from ffgym.studies import MotionStudy
from ffgym.studies.motions import name_motions, score_motion_study


def run(config: Simulate) -> None:
    """Check, simulate, write, print."""
    is_measured = config.sensors or is_workcell(config.robot)
    recordings = _check(config, is_measured)
    rig = _rig(config)
    motion = read_motion(config, rig.arm, config.path)
    if motion.reference.robot is not rig.robot:  # the motion brings its own tool
        if not isinstance(rig, SimulatedRig) or rig.machine is not None:
            raise FFGymError(f"{config.path} brings a tool of its own, but that of {config.robot} cannot be changed.")
        rig = replace(rig, arm=RigidArm(motion.reference.robot))
    # same motion under each agent
    motions = name_motions([motion.reference])
    setting = setting_for(rig, [motion.reference], config.parameters, config.threads)
    recorded = record_agents(
        config.feedforward,
        rig,
        motions,
        setting,
        controller=find_controller(config.robot),
        seed=config.seed,
        record_dt=config.record_dt_ms / 1e3,
        n_threads=config.threads,
    )
    study = score_motion_study(motions, recorded)
    seed = config.seed if is_measured else None  # null where nothing is random
    info = provenance("ffgym simulate", config, study.robot.name, study.fingerprint, seed)
    info |= {"motion": motion.reference.name, "duration": motion.reference.duration}
    info["events"] = list_events(motion)
    notes = [*motion.notes, *study.overloads]
    _write(config, study, recordings, info, notes)
    print("\n".join([format_motion(study), *(f"note: {note}" for note in notes), *tell_events(motion)]))
    for place in recordings.values():
        print_places(recording=place)
    print_places(report=config.report, numbers=config.json)


def _check(config: Simulate, is_measured: bool) -> dict[str, Path]:
    """Refuse what cannot be run or written; returns the recordings' places by law."""
    laws = check_laws(config.feedforward, "--feedforward", policies=True)
    simplified = ("parameters", "flexible", "friction", "gravity", "springs")
    refuse_with_policies(config.feedforward, given_options(config, simplified))
    if not is_measured and (given := given_options(config, ("seed",))):
        raise FFGymError(f"{given[0]} has no effect without --sensors: nothing else is random. Leave it out.")
    recordings: dict[str, Path] = {}
    if config.out is not None:
        check_choice("recording format", config.out.suffix, list(FORMATS))
        recordings = file_of_each(config.out, laws)
    places = {f"--out of {name}": path for name, path in recordings.items()}
    inputs = (config.robot, config.path, config.parameters, *config.feedforward)
    claim_outputs({**places, "--report": config.report, "--json": config.json}, inputs=inputs)
    return recordings


def _rig(config: Simulate) -> Rig:
    """Make the rig on which the motion is run."""
    if is_workcell(config.robot):
        if given := given_options(config, ("flexible", "friction", "gravity", "springs")):
            raise FFGymError(f"{given[0]} has no effect on {config.robot}, whose parameters are fixed. Leave it out.")
        return make_rig(config.robot)
    options = ModelOptions(
        flexible=config.flexible,
        friction=config.friction,
        gravity=config.gravity,
        springs=config.springs,
        looks=False,
    )
    rig = make_rig(config.robot, options=options)
    assert isinstance(rig, SimulatedRig)
    return replace(rig, sensors=sensors_of(rig.robot) if config.sensors else ())


def _write(
    config: Simulate, study: MotionStudy, recordings: dict[str, Path], info: dict[str, Any], notes: list[str]
) -> None:
    """Write files first, as printed text may go unread."""
    for law, place in recordings.items():
        write_recording(study.recordings[law, info["motion"]], place)
    if config.report is not None:
        write_text(config.report, render_motion_page(study, notes, info))
    places = {law: str(place) for law, place in recordings.items()}
    results = [asdict(result) for result in study.results]
    write_numbers(config, info | {"notes": notes, "recordings": places, "results": results})
