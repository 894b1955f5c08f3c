"""`ffgym play`: an episode of an environment with one agent or two, as a video, a still or in a window.

A file appears whole or not at all. Agents side by side meet the same seed, and so the same motion and machine.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from pathlib import Path
from typing import Any, TypeAlias

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from ffgym.agents.declaration import AgentSetting
from ffgym.cli.laws import make_agent, setting_for
from ffgym.cli.motion_options import Play
from ffgym.cli.outputs import claim_outputs, given_options, need_extra, print_places, provenance, write_numbers
from ffgym.cli.progress import progress_bar
from ffgym.control import Agent, FeedForwardLaw, Policy, find_channel, sees_errors
from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.core.files import replaced_file, write_bytes
from ffgym.core.measures import rms
from ffgym.core.registration import ENVIRONMENTS, find_spec
from ffgym.core.temporaries import temporary_folder
from ffgym.core.types import Array
from ffgym.envs.machines import WORKCELL, find_controller, is_workcell, make_rig
from ffgym.envs.rendering import Rendering
from ffgym.envs.rendering.viewer import check_screen
from ffgym.robot import RigidArm
from ffgym.simulation import SimulatedRig
from ffgym.simulation.plant.machine_file import is_machine_file

CIRCLES, CELLS, ADAPT = "ffgym/CirclePath", "ffgym/WorkcellCircles", "ffgym/Adapt"
"""Environments of circles, of any version; the second is that of workcells."""
AXIS, PATH = "ffgym/OneAxis", "ffgym/FollowPath"
NEEDED = {".mp4": ("imageio", "imageio-ffmpeg"), ".gif": ("imageio", "pillow"), ".png": ("imageio", "pillow")}
"""Packages of a video or a still by its suffix."""
Picture: TypeAlias = NDArray[np.uint8]


def run(config: Play) -> None:
    """Check, simulate and draw, write."""
    check(config)
    with ExitStack() as stack:
        players = make(config)
        for player in players:
            stack.callback(player.close)
        _begin(config, players)
        task = players[0].env.core.motions[0].task
        progress = stack.enter_context(progress_bar("filming", "steps"))
        frames = 1
        if config.window:
            results = _run(players, progress, lambda steps: None)
        elif config.out.suffix.lower() == ".png":
            picture, results = _draw_still(config, players, progress)
            _write_still(config.out, picture)
        else:
            with movie(config.out, config.fps) as append:
                frames, results = _film(config, players, append, progress)
        core = players[0].env.core
        robot, fingerprint = config.robot or core.robot.name, core.plant.fingerprint()
        info = provenance("ffgym play", config, robot, fingerprint, config.seed)
        info |= {"task": task, "frames": 0 if config.window else frames} | results[0]
        write_numbers(config, info | {"agents": results})
    for result in results:
        error = result["rms_path_error_mm"]
        print(f"{result['agent']}: return {result['return']:.2f}, length {result['length']}", end="")
        print("" if error is None else f", path error {error:.4f} mm RMS")
    if not config.window:
        print(f"frames: {frames}")
        print_places(picture=config.out)
    print_places(numbers=config.json)


def check(config: Play) -> None:
    """Refuse what cannot be played or written, before long work."""
    check_choice("environment", config.env, list(ENVIRONMENTS))
    for kinds, names in {
        (CIRCLES, CELLS, ADAPT): ("position", "speed_mm_s", "radii_mm"),
        (AXIS,): ("frequency_hz",),
        (PATH,): ("path",),
    }.items():
        given = [f"--{name.replace('_', '-')}" for name in names if getattr(config, name) not in (None, ())]
        if given and _kind(config) not in kinds:
            known = " or ".join(name for name in ENVIRONMENTS if name.rpartition("-")[0] in kinds)
            raise FFGymError(f"{' and '.join(given)} is for {known}, not for {config.env}; leave it out.")
    if len(config.agents) > 2:
        raise FFGymError(f"There is room for two agents, got {' '.join(config.agents)}; play two at a time.")
    if config.agents and given_options(config, ("law",)):
        raise FFGymError(f"--law {config.law} is for plays without named agents, got {' '.join(config.agents)} too.")
    check_number("playback", config.playback, low=1e-6, high=1000.0)
    check_number("fps", config.fps, unit="1/s", low=1.0, high=100.0)
    check_whole("seed", config.seed, low=0)
    if config.window:
        if given := given_options(config, ("out", "at", "fps", "playback")):
            raise FFGymError(f"{given[0]} has no effect in a window, which shows real time; leave it or --window out.")
        try:
            check_screen()
        except FFGymError as error:
            raise FFGymError(f"--window cannot be opened; leave it out to write a video. {error}") from error
        claim_outputs({"--json": config.json})
        return
    suffix = config.out.suffix.lower()
    if suffix not in NEEDED:
        raise FFGymError(f"{config.out}: a video must end in .mp4 or .gif, a still in .png, got {suffix!r}.")
    if config.at is not None:
        check_number("at", config.at, unit="s", low=0.0)
        if suffix != ".png":
            raise FFGymError(f"--at {config.at:g} is for a still, --out FILE.png, not for {config.out}; leave it out.")
    need_extra(f"A {suffix} picture" if suffix == ".png" else f"A {suffix} video", *NEEDED[suffix], extra="video")
    claim_outputs({"--out": config.out, "--json": config.json}, inputs=config.agents)


class Player:
    """An agent in an environment of its own, and what it did in the present episode.

    Args:
        name: name of the agent, as it was given.
        env: the environment; a law is its base.
        start: function that makes the agent of the environment; None adds nothing to the base.
    """

    def __init__(self, name: str, env: Any, start: Callable[[], Agent] | None) -> None:
        self.name, self.env, self._start = name, env, start
        self._agent: Agent | None = None

    def begin(self, seed: int) -> None:
        """Begin an episode, with a fresh agent."""
        self.close_agent()
        self._observation, _ = self.env.reset(seed=seed)
        self._agent, self._state = None if self._start is None else self._start(), None
        self._rewards: list[float] = []
        self._motor: list[Array] = []
        self.path: list[float] = []
        """Path error at each step [m]; nan where it does not count."""
        self.ended = self._terminated = False

    @property
    def length(self) -> int:
        """Steps done."""
        return len(self._rewards)

    @property
    def largest_error(self) -> tuple[float, int]:
        """Largest path error [m] and the steps until then; of the motors [rad] where there is no path."""
        size = np.array(self.path)
        if not np.isfinite(size).any():
            size = np.abs(self._motor).max(axis=1)
        step = int(np.nanargmax(size))
        return float(size[step]), step + 1

    def step(self) -> None:
        """Let the agent decide once, unless its episode has ended."""
        if self.ended:
            return
        action = np.zeros(self.env.action_space.shape)
        if self._agent is not None:
            starts = np.array([self.length == 0])
            actions, self._state = self._agent.predict(self._observation[None], self._state, starts, True)
            action = actions[0]
        is_scored = not self.env.core.motions[0].is_practice  # before the step, which may begin another motion
        self._observation, reward, self._terminated, truncated, info = self.env.step(action)
        self.ended = self._terminated or truncated
        self._rewards.append(float(reward))
        self._motor.append(self.env.core.signals.error[0].copy())
        counts = is_scored and "path_error" in info and info["phase"] in ("circle", "motion")
        self.path.append(info["path_error"] if counts else np.nan)

    def result(self) -> dict[str, Any]:
        """Summarise the episode for JSON."""
        path = np.array(self.path)[np.isfinite(self.path)]
        return {
            "agent": self.name,
            "return": float(np.sum(self._rewards)),
            "length": self.length,
            "terminated": bool(self._terminated),
            "rms_path_error_mm": 1e3 * rms(path) if len(path) else None,
            "rms_motor_error_rad": rms(np.array(self._motor), axis=0).tolist(),
        }

    def close_agent(self) -> None:
        """End the agent's process, if it has one."""
        close = getattr(self._agent, "close", None)
        if callable(close):
            close()

    def close(self) -> None:
        """End agent and environment."""
        self.close_agent()
        self.env.close()


def make(config: Play) -> list[Player]:
    """Make the agents, each in an environment of its own."""
    names = config.agents or (config.law,)
    # the episode without an agent: machine and motion, for agents that are made for them
    arguments = _arguments(config)
    empty: Any = gym.make(find_spec(config.env), **(arguments | {"base": "none"})).unwrapped
    with closing(empty):
        empty.reset(seed=config.seed)
        setting, controller = _setting(config, empty.core)
        fingerprint = empty.core.plant.fingerprint()
    with ExitStack() as made:
        players: list[Player] = []
        for name in names:
            title, agent = make_agent(name, setting, controller=controller, fingerprint=fingerprint)
            players.append(_make_player(config, name, title, agent, arguments))
            made.callback(players[-1].close)
        made.pop_all()  # nothing failed
    return players


def _make_player(
    config: Play, name: str, title: str, agent: FeedForwardLaw | Policy, arguments: dict[str, Any]
) -> Player:
    """Put an agent into an environment of its own."""
    if isinstance(agent, FeedForwardLaw):
        own: dict[str, Any] = {"base": agent}
    else:  # the observations that it was trained with; it brings its own base
        own = {"base": "none", "preview": agent.preview, "action_scale": agent.action_scale, "features": False}
        own |= {"track": "feedback" if sees_errors(agent) else "feed-forward", "channel": find_channel(agent)}
    rendering = Rendering(magnify=config.magnify, width=config.width, height=config.height, title=title)
    mode = "human" if config.window else "rgb_array"
    made = gym.make(find_spec(config.env), render_mode=mode, **(arguments | own | {"rendering": rendering}))
    env: Any = made.unwrapped
    if isinstance(agent, FeedForwardLaw):
        return Player(name, env, None)
    return Player(name, env, lambda: agent.agent(env.core.robot, env.core.observation_layout))


def _setting(config: Play, core: Any) -> tuple[AgentSetting, str]:
    """Give families what they make laws from, and the name of the controller's robot."""
    own = ENVIRONMENTS[config.env].defaults
    name = config.robot or own.get("robot")
    if name is None and _kind(config) == CELLS:
        name = WORKCELL + own.get("workcell", "thesis")
    if name is not None and is_workcell(name):
        rig = make_rig(name)
    else:
        rig = SimulatedRig(arm=RigidArm(core.robot), machine=core.plant.machines[0])
    return setting_for(rig, [core.motions[0].reference], None, 0), find_controller(name or core.robot.name)


def _kind(config: Play) -> str:
    """Return the id of the environment without its version."""
    return config.env.rpartition("-")[0]


def _arguments(config: Play) -> dict[str, Any]:
    """The environment's arguments, whatever its agent: size of pictures, machine and motions."""
    rendering = Rendering(magnify=config.magnify, width=config.width, height=config.height)
    arguments: dict[str, Any] = {"rendering": rendering} | _motion(config)
    name = config.robot
    if name is None:
        return arguments
    robot = make_rig(name).robot  # as the machine's controller knows it
    if _kind(config) == CELLS:
        if not is_workcell(name):
            raise FFGymError(f"--robot {name} is no workcell; give workcell:<name or seed>, or --env {CIRCLES}-v0.")
        return arguments | {"workcell": name.removeprefix(WORKCELL)}
    plant = {"plant": name} if is_workcell(name) or is_machine_file(name) else {}
    return arguments | {"robot": robot} | plant


def _motion(config: Play) -> dict[str, Any]:
    """The environment's arguments that say what is to be followed."""
    kind, radii = _kind(config), [radius / 1e3 for radius in config.radii_mm]
    if kind == AXIS:
        return {"frequencies": [1.0 if config.frequency_hz is None else config.frequency_hz]}
    if kind == PATH:
        return {} if config.path is None else {"path": config.path}
    if kind not in (CIRCLES, CELLS, ADAPT):
        return {}
    usual = ("p1", 40.0) if kind != ADAPT else (None, None)
    position = config.position or usual[0]
    speed = usual[1] if config.speed_mm_s is None else config.speed_mm_s
    chosen = {"positions": [position], "speeds": [None if speed is None else speed / 1e3], "radii": radii}
    return {name: values for name, values in chosen.items() if values not in ([], [None])}


def _begin(config: Play, players: Sequence[Player]) -> None:
    """Begin the same episode everywhere; an agent that cannot run there is named."""
    for player in players:
        try:
            player.begin(config.seed)
        except FFGymError as error:
            raise FFGymError(f"{player.name} cannot run in {config.env}: {error}") from error


def _run(
    players: Sequence[Player], progress: Callable[[float, float], None], look: Callable[[int], None]
) -> list[dict[str, Any]]:
    """Run the episode to its end and return the results; `look` is called with the steps done, from 0 on."""
    steps, total = 0, players[0].env.core.motions[0].n_steps
    look(steps)
    while not all(player.ended for player in players):
        for player in players:
            player.step()
        steps += 1
        look(steps)
        progress(steps, max(steps, total))
    return [player.result() for player in players]


def _film(
    config: Play, players: Sequence[Player], append: Callable[[Picture], None], progress: Callable[[float, float], None]
) -> tuple[int, list[dict[str, Any]]]:
    """Film the episode; frame k shows the first control step at or after time k playback / fps."""
    between = config.playback / config.fps / players[0].env.decision_dt  # control steps
    frames = 0

    def look(steps: int) -> None:
        """Append the frames due by now, at the ratio of film time to robot time."""
        nonlocal frames
        while frames * between <= steps + 1e-9:
            append(_picture(players))
            frames += 1

    results = _run(players, progress, look)
    return frames, results


def _draw_still(
    config: Play, players: Sequence[Player], progress: Callable[[float, float], None]
) -> tuple[Picture, list[dict[str, Any]]]:
    """Draw one picture: at --at, or at the largest error, for which the episode is run again until then."""
    dt, pictures = players[0].env.decision_dt, []
    moment = None if config.at is None else round(config.at / dt)

    def look(steps: int) -> None:
        """Take the picture if it is time."""
        if steps == moment:
            pictures.append(_picture(players))

    results = _run(players, progress, look)
    if config.at is not None and not pictures:
        end = max(player.length for player in players) * dt
        raise FFGymError(f"at = {config.at:g} s is after the end of the episode, {end:g} s; give an earlier time.")
    if not pictures:
        _, until = max(player.largest_error for player in players)
        _begin(config, players)
        for _ in range(until):
            for player in players:
                player.step()
        pictures.append(_picture(players))
    return pictures[0], results


def _write_still(path: Path, picture: Picture) -> None:
    """Write a picture (H, W, 3) as PNG, whole or not at all."""
    import imageio.v3 as imageio

    write_bytes(path, imageio.imwrite("<bytes>", picture, extension=".png"))


def _picture(players: Sequence[Player]) -> Picture:
    """Draw the players side by side, (H, W of all, 3)."""
    return np.hstack([player.env.render() for player in players])


@contextmanager
def movie(path: Path, fps: float) -> Iterator[Callable[[NDArray[np.uint8]], None]]:
    """Yield a function that appends a picture (H, W, 3); the file is at `path` when the block ends without an error.

    Raises:
        FFGymError: if the file cannot be written.
    """
    import imageio.v2 as imageio

    writer: Any = None
    with replaced_file(path) as temporary, temporary_folder(temporary.parent) as folder:
        file = folder / f"movie{path.suffix.lower()}"  # imageio goes by the suffix
        try:
            if file.suffix == ".gif":
                writer = imageio.get_writer(file, duration=1000 / fps, loop=0)
            else:
                writer = imageio.get_writer(file, fps=fps, codec="libx264", quality=8, macro_block_size=1)
            # video players do not take a last odd row or column
            yield lambda picture: writer.append_data(picture[: len(picture) // 2 * 2, : picture.shape[1] // 2 * 2])
            writer.close()
            os.replace(file, temporary)
        finally:
            if writer is not None:
                with suppress(Exception):  # after an error or Ctrl-C; the file goes anyway
                    writer.close()
