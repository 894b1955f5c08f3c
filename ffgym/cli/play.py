"""`ffgym play`: one episode of an environment as a video, which appears whole or not at all."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from uuid import uuid4

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from ffgym.cli.motion_options import Play
from ffgym.cli.outputs import check_outputs, need_extra, print_places, provenance, write_numbers
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.core.files import check_writable
from ffgym.core.measures import rms
from ffgym.core.registration import ENVIRONMENTS, find_spec
from ffgym.core.types import Array
from ffgym.envs import ResidualAction
from ffgym.envs.machines import WORKCELL, is_workcell, make_rig
from ffgym.envs.rendering import Rendering
from ffgym.simulation.plant.machine_file import is_machine_file
from ffgym.studies import thesis_laws

ACTION_SCALE = 8.0
"""Torque of an action of 1, in breakaway torques: enough for every law, so that none is clipped."""
CIRCLES = ("ffgym/CirclePath-v0", "ffgym/WorkcellCircles-v0")
"""Environments of the circle test; the second is that of workcells."""
USUAL = {"ffgym/OneAxis-v0": "one_axis", CIRCLES[1]: "workcell:thesis"}
"""Robots of environments that are not for the built-in arm."""
LAWS = {"none": "no compensation", "lugre_static": "static LuGre", "lugre_dynamic": "dynamic LuGre"}
"""Feed-forward laws, and what the picture calls them."""
NEEDED = {".mp4": ("imageio", "imageio-ffmpeg"), ".gif": ("imageio", "pillow")}
"""Packages of a video by its suffix."""


def run(config: Play) -> None:
    """Check, simulate and draw, write."""
    check(config)
    env = make(config)
    try:
        with progress_bar("filming", "steps") as progress, movie(config.out, config.fps) as append:
            result = _film(config, env, append, progress)
        robot, fingerprint = config.robot or env.core.robot.name, env.core.plant.fingerprint()
        info = provenance("ffgym play", config, robot, fingerprint, config.seed)
        write_numbers(config, info | {"task": env.core.motions[0].task} | result)
    finally:
        env.close()
    error = result["rms_path_error_mm"]
    print(f"{result['frames']} frames, return {result['return']:.2f}, length {result['length']}", end="")
    print("" if error is None else f", path error {error:.4f} mm RMS")
    print_places(video=config.out, numbers=config.json)


def check(config: Play) -> None:
    """Refuse what cannot be played or written, before long work."""
    check_choice("environment", config.env, list(ENVIRONMENTS))
    for kinds, names in {
        CIRCLES: ("position", "speed_mm_s", "radii_mm"),
        ("ffgym/OneAxis-v0",): ("frequency_hz",),
        ("ffgym/FollowPath-v0",): ("path",),
    }.items():
        given = [f"--{name.replace('_', '-')}" for name in names if getattr(config, name) not in (None, ())]
        if given and config.env not in kinds:
            raise FFGymError(f"{' and '.join(given)} is for {' or '.join(kinds)}, not for {config.env}; leave it out.")
    check_number("playback", config.playback, low=0.0, high=1000.0, open_low=True)
    check_number("fps", config.fps, unit="1/s", low=1.0, high=100.0)
    check_whole("seed", config.seed, low=0)
    suffix = config.out.suffix.lower()
    if suffix not in NEEDED:
        raise FFGymError(f"{config.out}: a video must end in {' or '.join(NEEDED)}, got {suffix!r}.")
    need_extra(f"A {suffix} video", *NEEDED[suffix], extra="video")
    check_writable(config.out)
    check_outputs({"--out": config.out, "--json": config.json})


def make(config: Play) -> Any:
    """The environment."""
    name = USUAL.get(config.env, "irb4600_60_205") if config.robot is None else config.robot
    robot = make_rig(name).robot  # as the machine's controller knows it
    machine: dict[str, Any] = {"robot": robot}
    if config.env == CIRCLES[1]:
        if not is_workcell(name):
            raise FFGymError(f"--robot {name} is no workcell; give workcell:<name or seed>, or --env {CIRCLES[0]}.")
        machine = {"workcell": name.removeprefix(WORKCELL)}
    elif is_workcell(name) or is_machine_file(name):
        machine["plant"] = name
    law = next(law for law in thesis_laws(robot) if law.name == config.law)
    return gym.make(
        find_spec(config.env),
        render_mode="rgb_array",
        layers=(ResidualAction(law),),
        action_scale=ACTION_SCALE,
        rendering=Rendering(magnify=config.magnify, width=config.width, height=config.height, title=LAWS[config.law]),
        **machine,
        **_motion(config),
    ).unwrapped


def _motion(config: Play) -> dict[str, Any]:
    """The environment's arguments that say what is to be followed."""
    if config.env == "ffgym/OneAxis-v0":
        return {"frequencies": [1.0 if config.frequency_hz is None else config.frequency_hz]}
    if config.env == "ffgym/FollowPath-v0":
        return {} if config.path is None else {"path": config.path}
    if config.env not in CIRCLES:
        return {}
    speed = 40.0 if config.speed_mm_s is None else config.speed_mm_s
    radii = {"radii": [radius / 1e3 for radius in config.radii_mm]} if config.radii_mm else {}
    return {"positions": [config.position or "p1"], "speeds": [speed / 1e3], **radii}


def _film(
    config: Play, env: Any, append: Callable[[NDArray[np.uint8]], None], progress: Callable[[float, float], None]
) -> dict[str, Any]:
    """Run an episode; frame k shows the first control step at or after time k playback / fps."""
    _, info = env.reset(seed=config.seed)
    action, total = np.zeros(env.action_space.shape), env.core.motions[0].n_steps
    between = config.playback / config.fps / env.decision_dt  # control steps
    rewards: list[float] = []
    path: list[float] = []
    motor: list[Array] = []
    frames, ended = 0, False
    while True:
        # frames due by now, at the ratio of film time to robot time
        while frames * between <= len(rewards) + 1e-9:
            append(env.render())
            frames += 1
        if ended:
            break
        _, reward, terminated, truncated, info = env.step(action)
        ended = terminated or truncated
        rewards.append(reward)
        motor.append(env.core.signals.error[0])
        if "path_error" in info and info["phase"] in ("circle", "motion"):
            path.append(info["path_error"])
        progress(len(rewards), total)
    return {
        "frames": frames,
        "return": float(np.sum(rewards)),
        "length": len(rewards),
        "terminated": bool(terminated),
        "rms_path_error_mm": 1e3 * rms(np.array(path)) if path else None,
        "rms_motor_error_rad": rms(np.array(motor), axis=0).tolist(),
    }


@contextmanager
def movie(path: Path, fps: float) -> Iterator[Callable[[NDArray[np.uint8]], None]]:
    """Yield a function that appends a picture (H, W, 3); the file is at `path` when the block ends without an error.

    Raises:
        FFGymError: if the file cannot be written.
    """
    import imageio.v2 as imageio

    target = Path(os.path.realpath(path))  # through a link, as an ordinary write does
    temporary = target.with_name(f".ffgym-{uuid4().hex}{target.suffix.lower()}")
    writer: Any = None
    try:
        if temporary.suffix == ".gif":
            writer = imageio.get_writer(temporary, duration=1000 / fps, loop=0)
        else:
            writer = imageio.get_writer(temporary, fps=fps, codec="libx264", quality=8, macro_block_size=1)
        # video players do not take a last odd row or column
        yield lambda picture: writer.append_data(picture[: len(picture) // 2 * 2, : picture.shape[1] // 2 * 2])
        writer.close()
        os.replace(temporary, target)
    except OSError as error:
        raise FFGymError(f"{path}: cannot be written: {error}. The folder must have space left.") from error
    finally:
        if writer is not None:
            with suppress(Exception):  # after an error or Ctrl-C; the file goes anyway
                writer.close()
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
