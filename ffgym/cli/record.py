"""`ffgym record`: measurement protocols on a machine, one recording for each motion."""

from dataclasses import replace
from textwrap import fill

from ffgym.cli.laws import check_laws, make_laws, setting_for
from ffgym.cli.motion_options import Record
from ffgym.cli.outputs import claim_outputs, given_folder, given_options, print_places, provenance, write_numbers
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import FFGymError, check_number
from ffgym.envs.machines import make_rig
from ffgym.recordings.io import INDEX
from ffgym.robot import RigidArm
from ffgym.simulation import Rig, SimulatedRig, TorqueSensor
from ffgym.simulation.protocols import PROTOCOLS, Protocol, load_protocols, plan_session, record_into, usual_sensors
from ffgym.simulation.protocols.protocol import JointProtocol
from ffgym.simulation.protocols.stage import ProtocolStage

LISTED_ROBOT = "irb4600_60_205"
"""Robot that --list tells durations for, if none is named."""

_PASSING = ("listing", "out", "json", "force", "threads", "format")
"""Options that only say where recordings go and how they are made."""


def run(config: Record) -> None:
    """Check, simulate, write, print."""
    if config.listing:
        print(protocol_list(make_rig(config.robot or LISTED_ROBOT).arm))
        return
    if config.robot is None or not config.protocols:
        raise FFGymError("Name a robot and what to record, e.g. one_axis diagnosis; --list shows the protocols.")
    # refuse options that contradict each other before anything moves
    folder = given_folder(config.out, "the recordings go")
    if config.exact and (given := given_options(config, ("seed", "torque_noise_percent"))):
        raise FFGymError(f"{given[0]} has no effect with --exact: nothing is measured. Leave one of them out.")
    if config.parameters is not None and config.feedforward == "none":
        raise FFGymError("--parameters has no effect without --feedforward: no law has a model. Leave it out.")
    check_laws([config.feedforward], "--feedforward")
    places = {"--json": config.json, "the index of the recordings": folder / INDEX if folder.exists() else None}
    claim_outputs(places, inputs=(config.robot, config.parameters, *config.protocols))
    # motions of the session, with one feedforward law for all
    rig = _rig(config, config.robot)
    start = 60.0 * check_number("--later-min", config.later_min, unit="min", low=0.0)
    motions = plan_session(rig.arm, _protocols(config), start=start)
    references = [motion.reference for motion in motions]
    (law,) = make_laws([config.feedforward], setting_for(rig, references, config.parameters, config.threads))
    seed = None if config.exact else config.seed
    origin = provenance("ffgym record", config, rig.robot.name, rig.fingerprint, seed, passing=_PASSING)
    # record what the folder lacks
    with progress_bar("recording", "s") as progress:
        session = record_into(
            folder,
            motions,
            rig,
            law=law,
            seed=config.seed,
            record_dt=config.record_dt_ms / 1e3,
            origin={name: origin[name] for name in ("command", "config")},
            suffix=f".{config.format}",
            force=config.force,
            n_threads=config.threads,
            progress=progress,
        )
    write_numbers(config, session.index | {"folder": str(folder), "made": session.made, "kept": session.kept})
    seconds = sum(reference.duration for reference in references)
    before = f", {session.kept} were complete before" if session.kept else ""
    print(f"{session.made} recordings of {len(motions)} made{before}; {seconds:.0f} s of motion in all")
    print_places(recordings=folder, index=folder / INDEX, numbers=config.json)


def _rig(config: Record, robot: str) -> Rig:
    """Make the rig on which the motions are run, with the sensors of a simulated robot."""
    rig = make_rig(robot)
    if not isinstance(rig, SimulatedRig):
        if given := given_options(config, ("exact", "torque_noise_percent")):
            raise FFGymError(f"{given[0]} is not for {robot}: its sensors are its own, its truth is shut away.")
        return rig
    if config.exact:
        return replace(rig, sensors=())
    noise = check_number("--torque-noise-percent", config.torque_noise_percent, unit="%", low=0.0, high=100.0) / 100
    torque = (TorqueSensor(noise=noise * rig.robot.drive.peak_torque),) if noise > 0 else ()
    return replace(rig, sensors=(*usual_sensors(rig.robot), *torque))


def _protocols(config: Record) -> list[Protocol]:
    """Protocols as they are named, for the joints that are."""
    protocols = [protocol for name in config.protocols for protocol in load_protocols(name)]
    if not config.joints:
        return protocols
    chosen: list[Protocol] = []
    for protocol in protocols:
        if not isinstance(protocol, JointProtocol):
            raise FFGymError(
                f"--joints has no effect on {protocol.name}, which moves the tool or says itself what moves."
            )
        chosen.append(replace(protocol, joints=config.joints))
    return chosen


def protocol_list(arm: RigidArm) -> str:
    """Text with one paragraph for each protocol, how long it takes; one that the robot cannot run says why."""
    paragraphs = [
        f"On {arm.robot.name!r}, with default settings (docs/protocols.md); durations are those of the motions."
    ]
    for name, protocol in PROTOCOLS.items():
        try:
            motions = protocol().motions(ProtocolStage(arm=arm))  # without the torques, which take longer to look at
        except FFGymError as error:
            size = f"cannot be run: {error}"
        else:
            number = f"{len(motions)} motion{'s' if len(motions) > 1 else ''}"
            size = f"{number}, {sum(motion.reference.duration for motion in motions):.0f} s"
        paragraphs.append(fill(f"{name}: {size}. {protocol.purpose[0].upper()}{protocol.purpose[1:]}.", 110))
    return "\n".join(paragraphs)
