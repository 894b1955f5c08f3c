"""`ffgym stream`: a plan of set-points to a robot controller in real time."""

from contextlib import closing

import numpy as np

from ffgym.cli.outputs import claim_outputs, print_places, provenance, write_numbers
from ffgym.cli.stream_options import Stream
from ffgym.control import CorrectionLimits
from ffgym.core.errors import FFGymError, check_choice, check_number
from ffgym.deployment.plan import SetpointPlan, check_fits, read_plan
from ffgym.deployment.streams.envelope import LONGEST_SILENCE, Envelope, usual_silence
from ffgym.deployment.streams.live import Timing, run_live
from ffgym.deployment.streams.protocols import axes_of, protocol_named
from ffgym.deployment.streams.recording import record_session, summarise
from ffgym.deployment.streams.session import StreamSession
from ffgym.envs.machines import load_described_robot
from ffgym.recordings.io import FORMATS, write_recording
from ffgym.robot import RobotDescription, builtin_parameters, builtin_robots


def run(config: Stream) -> None:
    """Check, stream, write, print."""
    if config.out is not None:
        check_choice("recording format", config.out.suffix, list(FORMATS))
    claim_outputs({"--out": config.out, "--json": config.json}, inputs=(config.plan, config.robot))
    plan = read_plan(config.plan)
    robot = load_described_robot(name_robot(plan, config.robot))
    check_fits(plan, robot)
    protocol = protocol_named(config.protocol)
    wire = protocol.make_wire(axes_of(robot))
    session = StreamSession(plan, wire, make_envelope(config, robot, wire.cycle), robot.drive)
    with closing(protocol.open_stream(config.address)) as port:
        print(f"{plan.name} with {plan.law}, {plan.t[-1]:g} s; waits for {protocol.title}")
        if session.cut_share > 0:
            print(f"note: the plan exceeds the limits of the correction by {session.cut_share:.0%}, and is cut to them")
        timing = run_live(session, port, wait=config.wait_s)
    recording = record_session(session, robot)
    if config.out is not None:
        write_recording(recording, config.out)
    origin = provenance("ffgym stream", config, robot.name, None, None, passing=("out", "json"))
    write_numbers(config, origin | summarise(session) | {"answers": timing.summary()})
    print("\n".join(describe_session(session, timing)))
    print_places(recording=config.out, numbers=config.json)
    if session.state == "lost":
        raise FFGymError("The controller fell silent before the plan ended. The robot stops by its own rules.")


def name_robot(plan: SetpointPlan, named: str | None) -> str:
    """Name the robot of a plan: the one that is named, otherwise the built-in one that the plan is of.

    Raises:
        FFGymError: if none is named, and that of the plan has a description that is not built in.
    """
    if named is None and plan.robot not in {*builtin_robots(), *builtin_parameters()}:
        raise FFGymError(
            f"Plan {plan.name!r} is of robot {plan.robot!r}, which is not built in. Name its description: --robot FILE."
        )
    return named or plan.robot


def make_envelope(config: Stream, robot: RobotDescription, cycle: float) -> Envelope:
    """Make the safety envelope of the options, for a controller whose cycle is `cycle` [s]."""
    patience = usual_silence(cycle) if config.patience_ms is None else 1e-3 * config.patience_ms
    left = LONGEST_SILENCE - patience
    ramp = min(Envelope.ramp, left if left > 0 else Envelope.ramp) if config.ramp_ms is None else 1e-3 * config.ramp_ms
    limits = {
        "size": 1e-3 * _check_limit("--largest-mrad", config.largest_mrad, "mrad"),
        "rate": 1e-3 * _check_limit("--largest-rate-mrad-s", config.largest_rate_mrad_s, "mrad/s"),
        "acceleration": _check_limit("--largest-acceleration-rad-s2", config.largest_acceleration_rad_s2, "rad/s^2"),
    }
    return Envelope(
        correction=CorrectionLimits.even(robot.n_joints, **limits),
        torque=np.asarray(robot.drive.peak_torque),
        patience=patience,
        ramp=ramp,
        fade=1e-3 * config.fade_ms,
        start_tolerance=1e-3 * config.start_tolerance_mrad,
    )


def _check_limit(option: str, value: float, unit: str) -> float:
    """Return a limit of corrections, which is no smaller and no larger than any that a robot moves by."""
    return check_number(option, value, unit=unit, low=1e-6, high=1e9)


def describe_session(session: StreamSession, timing: Timing) -> list[str]:
    """Say how a session went."""
    told = summarise(session)
    largest = ", ".join(f"{1e3 * value:.3f}" for value in told["largest_correction"])
    lines = [
        f"{told['state']}: {told['sent']} set-points for {told['received']} packets",
        f"largest correction per joint [mrad, mm]: {largest}",
    ]
    if answers := timing.summary():
        lines.append(f"answers took {answers['median_us']:.0f} us (99 %: {answers['p99_us']:.0f})")
    if told["refused"]:
        lines.append("refused: " + ", ".join(f"{count} {reason}" for reason, count in told["refused"].items()))
    if (lost := told["correction_lost_after"]) is not None:
        lines.append(f"note: the controller was silent at {lost:.3f} s; from then on the correction was out")
    if session.is_stopped:
        lines.append("note: stopped; the correction left, the program went on")
    return lines
