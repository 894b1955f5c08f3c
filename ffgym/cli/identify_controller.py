"""`ffgym identify controller`: delay and smoothing filter of a controller from a recording of set-points."""

from dataclasses import asdict

from ffgym.cli.outputs import check_outputs, hash_inputs, print_places, provenance, write_numbers
from ffgym.cli.progress import progress_bar
from ffgym.cli.stream_options import IdentifyController
from ffgym.core.errors import FFGymError
from ffgym.deployment.controller_file import write_controller
from ffgym.diagnosis.identification import ResponseFit, identify_response
from ffgym.envs.machines import load_described_robot
from ffgym.logs import read_logs
from ffgym.robot import RigidArm


def run(config: IdentifyController) -> None:
    """Check, identify, write, print."""
    if not config.logs:
        raise FFGymError(
            "No logs are given. Name recordings as ffgym stream writes them: ffgym identify controller LOGS."
        )
    check_outputs({"--out": config.out, "--json": config.json}, inputs=(*config.logs, config.robot), suffix=".toml")
    robot = load_described_robot(config.robot)
    recordings = [
        recording
        for path in config.logs
        for recording in read_logs(path, config.columns, robot=None if config.columns is None else robot)
    ]
    with progress_bar("identifying", "fits") as progress:
        fit = identify_response(recordings, RigidArm(robot), n_threads=config.threads, progress=progress)
    if config.out is not None:
        source = f"identified from {', '.join(path.name for path in config.logs)}"
        write_controller(config.out, fit.response, source=source, intervals=fit.intervals)
    info = provenance("ffgym identify controller", config, robot.name, None, None)
    info["inputs"] = hash_inputs((*config.logs, config.robot, config.columns))
    write_numbers(config, info | _numbers(fit))
    print("\n".join(_describe(fit, robot.joints)))
    print_places(controller=config.out, numbers=config.json)


def _numbers(fit: ResponseFit) -> dict[str, object]:
    """Everything, as JSON has it; joints at rest have no residual."""
    return {
        "response": asdict(fit.response),
        "intervals": {name: list(ends) for name, ends in fit.intervals.items()},
        "explained": fit.explained,
        "residual_rad": [float(value) if value == value else None for value in fit.residual],
        "factors": {name: values.tolist() for name, values in fit.factors.items()},
    }


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
