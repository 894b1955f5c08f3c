"""`ffgym emulate`: a robot controller with a simulated robot behind it, on the network of this computer."""

from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.cli.export import load_machine_or_robot
from ffgym.cli.outputs import claim_outputs, given_options, print_places, provenance, write_numbers
from ffgym.cli.progress import progress_bar
from ffgym.cli.stream import describe_session, make_envelope
from ffgym.cli.stream_options import Emulate, Stream
from ffgym.control import SetpointResponse
from ffgym.core.errors import FFGymError, check_choice, check_number
from ffgym.core.types import Array
from ffgym.deployment.plan import SetpointPlan, check_fits, read_plan
from ffgym.deployment.streams.emulators import (
    DirectTorque,
    EmulatedController,
    EmulatedRobot,
    Faults,
    record_drive,
    run_in_lock_step,
)
from ffgym.deployment.streams.emulators.live import serve_live
from ffgym.deployment.streams.live import Timing
from ffgym.deployment.streams.protocols import axes_of, protocol_named
from ffgym.deployment.streams.recording import record_session, summarise
from ffgym.deployment.streams.session import StreamSession, sample_plan
from ffgym.recordings.io import FORMATS, write_recording
from ffgym.robot import RobotDescription

_SPARE = 30.0
"""Time beyond a plan in which a stream of it has ended [s]; chosen."""
_FEW = 0.01
"""Share of cycles that may begin late before a note says so; chosen."""


def run(config: Emulate) -> None:
    """Check, emulate, write, print."""
    _check(config)
    controller, plan = _make_controller(config)
    emulated, late = controller.robot, 0
    title = protocol_named(config.protocol).title
    print(f"{title} of {emulated.robot.name}, {emulated.response.describe()}", flush=True)
    if plan is not None and (counted := plan.meta.get("feedforward", config.feedforward)) != config.feedforward:
        print(
            f"note: the plan counts on rigid feed-forward from {counted}, the emulator computes it from "
            f"{config.feedforward}: --feedforward {counted}"
        )
    stream: dict[str, Any] = {}
    if plan is not None and config.log is not None:
        stream = {"stream": _stream_in_lock_step(config, plan, config.log, controller)}
    else:
        late = _serve(config, controller)
    if config.out is not None:
        write_recording(emulated.truth("emulated"), config.out)
    fingerprint = emulated.plant.fingerprint()
    origin = provenance("ffgym emulate", config, emulated.robot.name, fingerprint, config.seed, passing=("out", "json"))
    told = {
        "cycles": emulated.cycles,
        "cycles_that_began_late": late,
        "cycles_without_setpoint": emulated.missed,
        "refused": dict(sorted(controller.refused.items())),
    }
    write_numbers(config, origin | told | stream)
    print(
        f"{emulated.cycles} cycles, {emulated.missed} without a set-point, {late} began late; "
        f"{'a stream came' if controller.begun else 'no stream came'}"
    )
    if late > _FEW * emulated.cycles:
        print("note: this computer is too busy to keep the controller's time; --log emulates a stream without a clock")
    print_places(recording=config.out, log=config.log, numbers=config.json)


def _check(config: Emulate) -> None:
    """Check outputs, and that there is a plan where one is streamed."""
    places = {"--out": config.out, "--log": config.log}
    for place in places.values():
        if place is not None:
            check_choice("recording format", place.suffix, list(FORMATS))
    claim_outputs({**places, "--json": config.json}, inputs=(config.plan, config.robot))
    if config.torque and config.log is None:
        raise FFGymError("--torque has no effect without --log. Leave it out, or name a log.")
    if config.log is not None and (given := given_options(config, ("address", "longest_s"))):
        raise FFGymError(f"{given[0]} has no effect with --log, which needs no network. Leave one of them out.")
    if config.log is not None and config.plan is None:
        raise FFGymError(f"--log {config.log}: there is no plan to stream. Name one: --plan.")


def _make_controller(config: Emulate) -> tuple[EmulatedController, SetpointPlan | None]:
    """Make the controller with its robot, at the first pose of the plan if there is one; returns the plan, too."""
    _, machine = load_machine_or_robot(config.robot)
    robot, protocol = machine.robot, protocol_named(config.protocol)
    wire = protocol.make_wire(axes_of(robot))
    plan = _read_plan(config, robot)
    if wire.needs_answers and plan is None:
        raise FFGymError(f"{protocol.title}: the controller runs the program itself; name its plan: --plan.")
    emulated = EmulatedRobot(
        machine,
        _find_home(robot) if plan is None else plan.program[0],
        cycle=wire.cycle,
        response=_response(config),
        feedforward=config.feedforward,
        missing=config.missing,
        program=sample_plan(plan, wire.cycle)[0] if plan is not None and wire.needs_answers else None,
    )
    scales = DirectTorque(viscous_scale=config.viscous_scale, coulomb_scale=config.coulomb_scale)
    return EmulatedController(emulated, wire, direct_torque=scales if wire.torques else None), plan


def _serve(config: Emulate, controller: EmulatedController) -> int:
    """Serve a stream over the network in real time; returns the number of cycles that began late."""
    faults = _faults(config)
    port, receiver = protocol_named(config.protocol).open_emulator(config.address, config.longest_s)
    with closing(port):
        return serve_live(controller, port, receiver, to_stream=faults, to_controller=faults, longest=config.longest_s)


def _stream_in_lock_step(
    config: Emulate, plan: SetpointPlan, log: Path, controller: EmulatedController
) -> dict[str, Any]:
    """Stream a plan to the emulator without network and clock, as `ffgym stream` does by default; write its log.

    Returns what `ffgym stream` writes as its numbers.
    """
    assert config.plan is not None
    robot, faults = controller.robot.robot, _faults(config)
    envelope = make_envelope(Stream(config.plan), robot, controller.wire.cycle)
    session = StreamSession(plan, controller.wire, envelope, robot.drive)
    with progress_bar("emulating", "s") as progress:
        run_in_lock_step(
            session,
            controller,
            to_stream=faults,
            to_controller=faults,
            longest=float(plan.t[-1]) + _SPARE,
            progress=progress,
        )
    write_recording(record_drive(session, controller) if config.torque else record_session(session, robot), log)
    print("\n".join(describe_session(session, Timing())))
    return summarise(session)


def _read_plan(config: Emulate, robot: RobotDescription) -> SetpointPlan | None:
    """Read the plan that tells where the robot stands, if there is one."""
    if config.plan is None:
        return None
    plan = read_plan(config.plan)
    check_fits(plan, robot)
    return plan


def _find_home(robot: RobotDescription) -> Array:
    """Return the joint positions at which a robot without a plan stands, link side."""
    if robot.work_area is None:
        return np.clip(np.zeros(robot.n_joints), *robot.kinematics.range.T)
    return np.asarray(robot.work_area.home, dtype=np.float64)


def _response(config: Emulate) -> SetpointResponse:
    """Make delay and filter of the controller."""
    delay = 1e-3 * check_number("--delay-ms", config.delay_ms, unit="ms", low=0.0)
    if config.cutoff_hz is None:
        if config.damping is not None:
            raise FFGymError("--damping has no effect without --cutoff-hz. Leave it out, or give both.")
        return SetpointResponse(delay=delay)
    return SetpointResponse.low_pass(config.cutoff_hz, delay=delay, damping=config.damping)


def _faults(config: Emulate) -> Faults:
    """Make the faults of the network, the same in both directions."""
    return Faults(
        drop=config.drop,
        corrupt=config.corrupt,
        duplicate=config.duplicate,
        late=config.late,
        latency=1e-3 * config.latency_ms,
        jitter=1e-3 * config.jitter_ms,
        seed=config.seed,
    )
