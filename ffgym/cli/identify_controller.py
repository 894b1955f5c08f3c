"""`ffgym identify controller`: delay and filter of a controller, and gains of its servo, from recordings."""

from dataclasses import asdict

import numpy as np

from ffgym.cli.outputs import claim_outputs, hash_inputs, print_places, provenance, write_numbers
from ffgym.cli.progress import progress_bar
from ffgym.cli.stream_options import IdentifyController
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.deployment.controller_file import write_controller
from ffgym.diagnosis.identification import ControllerFit, ResponseFit, identify_controller
from ffgym.diagnosis.identification.servo_gains import GAINS
from ffgym.envs.machines import load_described_robot
from ffgym.logs import read_logs
from ffgym.robot import RigidArm


def run(config: IdentifyController) -> None:
    """Check, identify, write, print."""
    if not config.logs:
        raise FFGymError(
            "No logs are given. Name recordings as ffgym stream writes them: ffgym identify controller LOGS."
        )
    claim_outputs({"--out": config.out, "--json": config.json}, inputs=(*config.logs, config.robot), suffix=".toml")
    robot = load_described_robot(config.robot)
    recordings = [
        recording
        for path in config.logs
        for recording in read_logs(path, config.columns, robot=None if config.columns is None else robot)
    ]
    feedforward = config.controller_feedforward == "setpoints"
    with progress_bar("identifying", "fits") as progress:
        fit = identify_controller(
            recordings, RigidArm(robot), feedforward=feedforward, n_threads=config.threads, progress=progress
        )
    if config.out is not None:
        _write(config, fit, robot.joints)
    info = provenance("ffgym identify controller", config, robot.name, None, None)
    info["inputs"] = hash_inputs((*config.logs, config.robot, config.columns))
    write_numbers(config, info | _numbers(fit))
    print("\n".join([*_describe(fit.response, robot.joints), *_describe_servo(fit, robot.joints)]))
    print_places(controller=config.out, numbers=config.json)


def _write(config: IdentifyController, fit: ControllerFit, joints: tuple[str, ...]) -> None:
    """Write the file of the controller, with gains if any was found."""
    assert config.out is not None
    source = f"identified from {', '.join(path.name for path in config.logs)}"
    servo, response = fit.servo, fit.response
    if servo is None or len(servo.refused) == len(GAINS) * len(joints):
        write_controller(config.out, response.response, source=source, intervals=response.intervals)
        return
    ends = {name: [(each[i].low, each[i].high) for each in servo.estimates] for i, name in enumerate(GAINS)}
    write_controller(
        config.out,
        response.response,
        source=source,
        intervals=response.intervals,
        servo=servo.servo,
        joints=joints,
        gain_intervals={name: np.array(pairs) for name, pairs in ends.items()},
        documented=[f"{each.joint}.{each.name.removeprefix('servo.')}" for each in servo.refused],
    )


def _numbers(fit: ControllerFit) -> dict[str, object]:
    """Everything, as JSON has it; joints at rest have no residual, and nothing of a servo without torque is known."""
    response, servo = fit.response, fit.servo
    found: dict[str, object] = {
        "response": asdict(response.response),
        "intervals": {name: list(ends) for name, ends in response.intervals.items()},
        "explained": response.explained,
        "residual_rad": _or_none(response.residual),
        "factors": {name: values.tolist() for name, values in response.factors.items()},
        "no_torque": fit.no_torque,
        "servo": None,
    }
    if servo is not None:
        found["servo"] = {
            "gains": [
                asdict(each) | {"high": each.high if np.isfinite(each.high) else None}
                for joint in servo.estimates
                for each in joint
            ],
            "explained": _or_none(servo.explained),
            "feedforward_factor": _or_none(servo.feedforward),
        }
    return found


def _or_none(values: Array) -> list[float | None]:
    """List numbers, None where there is none."""
    return [float(value) if np.isfinite(value) else None for value in values]


def _describe_servo(fit: ControllerFit, joints: tuple[str, ...]) -> list[str]:
    """Say which gains were found, and why others were not."""
    if fit.servo is None:
        return [f"gains of the servo: those of the description, as {fit.no_torque}"]
    lines = ["gains of the servo, motor side, with 95 % intervals:"]
    for joint, gains, explained in zip(joints, fit.servo.estimates, fit.servo.explained, strict=True):
        parts = [
            f"{each.name.removeprefix('servo.')} {each.value:.4g} ({each.low:.4g} to {each.high:.4g}, "
            f"documented {each.prior:.4g}) {each.unit}"
            for each in gains
            if each.is_identified
        ]
        lines += [f"{joint}: {'; '.join(parts)}; left-out torque explained: {explained:.2%}"] if parts else []
    return lines + [
        f"{each.joint}: {each.name.removeprefix('servo.')} stays {each.prior:.4g}: {each.reason}"
        for each in fit.servo.refused
    ]


def _describe(fit: ResponseFit, joints: tuple[str, ...]) -> list[str]:
    """Say what was found."""
    units = {"total_delay": ("ms", 1e3), "delay": ("ms", 1e3), "lag": ("ms", 1e3), "curvature": ("ms^2", 1e6)}
    titles = {"total_delay": "delay + lag, which paths need"}
    lines = [fit.response.describe()]
    for name, (low, high) in fit.intervals.items():
        unit, scale = units[name]
        value = getattr(fit.response, name)
        title = titles.get(name, name)
        lines.append(f"{title}: {scale * value:.3f} {unit}, 95 % interval {scale * low:.3f} to {scale * high:.3f}")
    lines.append("intervals know noise alone; how the drive makes speeds of set-points moves delay against lag by more")
    lines.append(f"explained variance of what the delay leaves: {fit.explained:.2%}")
    left = ", ".join(
        f"{joint} {1e3 * value:.3f}" for joint, value in zip(joints, fit.residual, strict=True) if value == value
    )
    return [*lines, f"left between model and motors, RMS [mrad], motor side: {left}"]
