"""Results of one row of the leaderboard as a file: every seed on every plant, every circle."""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Self

from ffgym.control import SetpointChannel, SetpointResponse
from ffgym.control.observation import Channel
from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.core.files import read_text
from ffgym.core.typed_json import from_json, parse_json
from ffgym.envs.machines import is_workcell
from ffgym.leaderboard.plants import NOMINAL, draw_number
from ffgym.leaderboard.tasks import SPLITS

FORMAT = 1
"""Version of the file format; see docs/leaderboard/results.md."""
DIGITS = 6
"""Significant digits of errors in files: of the largest error, a thousandth of the tracker's resolution."""

FEED_FORWARD, WITH_FEEDBACK = "feed-forward", "with feedback"
"""Tracks: from the reference and what is remembered of earlier motions; with present errors of the motors, too."""
CHANNEL_TITLES: Mapping[Channel, str] = {"torque": "torque", "setpoint": "set-points"}
"""Titles of the channels: what an agent acts on, torques of the motors or positions that their servos follow."""

_AGAIN = "Remove it, and run `ffgym leaderboard` again."


@dataclass(frozen=True, kw_only=True)
class CircleResult:
    """Errors on one circle: of the path [mm], of motors [rad]; None where the robot stopped before its end."""

    split: str
    position: str
    radius_mm: float
    speed_mm_s: float
    rms_mm: float | None = None
    """RMS path error in the plane of the circle, as in the thesis."""
    max_mm: float | None = None
    rms_3d_mm: float | None = None
    """RMS path error in space."""
    max_3d_mm: float | None = None
    motor_rms_rad: tuple[float, ...] | None = None
    """RMS error of each motor over lead-in, circle and lead-out."""

    @property
    def key(self) -> tuple[str, str, float, float]:
        """Identity of the circle: split, position, radius [mm], speed [mm/s]."""
        return self.split, self.position, self.radius_mm, self.speed_mm_s


@dataclass(frozen=True, kw_only=True)
class Trail:
    """Path of the tool on one circle, for pictures."""

    position: str
    radius_mm: float
    speed_mm_s: float
    deviation_um: tuple[float, ...]
    """Outward deviation from the circle at even times, in its plane."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """One agent with one seed on one plant."""

    seed: int
    """Seed of its training and, on the workcell, of the sensors' noise."""
    plant: str
    """Name of the plant: 'nominal', 'workcell:<name>' or 'draw:<k>'."""
    fingerprint: str
    """Fingerprint of the plant's physics."""
    versions: str
    """Versions of everything that can change a number, as 'ffgym 0.1.0, mujoco 4.0.0'; several runs in a row."""
    artefact: str | None
    """sha256 of the file that the agent was read from; None if it was made from the robot's description alone."""
    robot_seconds: float
    """Time that a machine moved while the agent learned for this plant [s]."""
    env_steps: int
    """Control steps of simulated training, which cost no robot time."""
    inference_us: float | None
    """Median time of one decision for one robot [us]; None for a law that is computed before the motion."""
    cells: tuple[CircleResult, ...]
    trails: tuple[Trail, ...] = ()
    """Trails of some circles, for pictures."""

    @property
    def plant_draw(self) -> int | None:
        """Number of the drawn plant; None for others."""
        return draw_number(self.plant)

    @property
    def key(self) -> tuple[int, str]:
        """Identity of the outcome: seed, plant."""
        return self.seed, self.plant


@dataclass(frozen=True, kw_only=True)
class Margins:
    """Stability margins of one seed of an agent with feedback, see `ffgym.leaderboard.evaluation.margins`."""

    seed: int
    fingerprint: str
    """Fingerprint of the physics of the machine with drives that they were measured on."""
    artefact: str | None
    """sha256 of the file that the agent was read from."""
    gain: float
    """Largest factor on the agent's own torque with which the loop is stable; 0 if it bears no factor that was tried,
    below 1 if the loop is unstable as it is."""
    delay_ms: float | None = None
    """Largest added delay of the agent's own torque with which the loop is stable [ms]; None if it is unstable without
    any."""


@dataclass(frozen=True, kw_only=True)
class SentSetpoints:
    """Set-points that an agent acts through, one at every sample of the controller: 4 ms, as EGM at 250 Hz."""

    response: SetpointResponse = field(default_factory=SetpointResponse)
    """What the controller does to them between sender and servo."""
    known: SetpointResponse = field(default_factory=SetpointResponse)
    """What the sender compensates of it."""

    @classmethod
    def through(cls, channel: SetpointChannel) -> Self:
        """Describe what is sent through a channel."""
        return cls(response=channel.response, known=channel.compensated)

    @property
    def lateness_ms(self) -> float:
        """Time by which set-points are late at low frequencies [ms], after all that the sender compensates."""
        return (self.response.total_delay - self.known.total_delay) * 1e3

    def describe(self) -> str:
        """Describe delay and filter of the controller, and what is compensated, in one phrase."""
        nothing = SetpointResponse()
        if self.response == self.known == nothing:
            return nothing.describe()
        known = {self.response: "compensated", nothing: "not compensated"}
        what = known.get(self.known, f"compensated as {self.known.describe()}")
        return f"{self.response.describe()}, {what}"


@dataclass(frozen=True, kw_only=True)
class Row:
    """One agent on the leaderboard."""

    name: str
    title: str
    track: str
    """Knowledge of the agent; see `ffgym.agents.declaration.Track`."""
    about: str
    """One or two sentences: method, and data that it learned from."""
    page: str | None
    """Page below docs/agents."""
    base: str | None
    """Name of the row that it is a residual on."""
    seeded: bool
    """True if a seed changes it."""
    command: str | None
    """Command that makes its artefacts again."""
    ranked: bool
    """False for rows that are shown only."""
    outcomes: tuple[Outcome, ...]
    learning_curve: tuple[tuple[float, float], ...] = ()
    """Steps of training, mean reward per step over seeds; empty without training in steps."""
    feedback: bool = False
    """True if it observes present errors of the motors."""
    margins: tuple[Margins, ...] = ()
    """Stability margins by seed; empty for rows of the track feed-forward, and where they were not measured."""
    setpoints: SentSetpoints | None = None
    """Set-points that it acts through; None adds torque."""

    @property
    def control(self) -> str:
        """Track of the two that are told apart: 'feed-forward' or 'with feedback'."""
        return WITH_FEEDBACK if self.feedback else FEED_FORWARD

    @property
    def channel(self) -> Channel:
        """Channel that it acts through: 'torque' or 'setpoint'."""
        return "torque" if self.setpoints is None else "setpoint"


def encode_row(row: Row) -> str:
    """Encode a row as the text of its file: one line per circle, so that differences can be read."""
    head = {"format": FORMAT} | {key: value for key, value in asdict(row).items() if key != "outcomes"}
    head |= {"margins": [_short(asdict(each)) for each in row.margins]}
    for name in ("margins", "setpoints"):  # which rows without them lack
        if not head[name]:
            del head[name]
    lines = []
    for outcome in row.outcomes:
        entry = asdict(outcome)
        cells = ",\n".join("   " + json.dumps(_short(cell), allow_nan=False) for cell in entry.pop("cells"))
        start = json.dumps(_short(entry), allow_nan=False)[:-1]
        lines.append(f'  {start}, "cells": [\n{cells}]}}')
    text = json.dumps(head, indent=1, allow_nan=False)[:-2]
    body = ",\n".join(lines)
    return f'{text},\n "outcomes": [\n{body}\n ]\n}}\n'


def read_row(path: Path) -> Row:
    """Read a row's file.

    Raises:
        FFGymError: if the file cannot be read, is damaged, or of another format.
    """
    return decode_row(read_text(path), str(path))


def decode_row(text: str, path: str) -> Row:
    """Decode the row in the text of a file; FFGymError that names the path if it is damaged, or of another format."""
    tree = parse_json(text, path, _AGAIN)
    # format before content, as files of other versions are no damage
    found = tree.get("format") if isinstance(tree, dict) else None
    if found != FORMAT:
        raise FFGymError(f"{path}: has format {found!r}, this version of ffgym reads {FORMAT}.")
    try:
        # structure, then the values that must be names, numbers or unique
        tree = {"feedback": False, "margins": [], "setpoints": None} | {  # which older ones lack, and rows without
            key: value for key, value in tree.items() if key != "format"
        }
        row: Row = from_json(Row, tree, "row")
        _check_once("outcome", [outcome.key for outcome in row.outcomes])
        _check_once("seed of margins", [each.seed for each in row.margins])
        for each in row.margins:
            check_number("margins.gain", each.gain, low=0.0)
        for outcome in row.outcomes:
            name = outcome.plant
            if name != NOMINAL and not is_workcell(name) and draw_number(name) is None:
                raise FFGymError(f"plant = {name!r} must be nominal, workcell:<name or seed> or draw:<number>.")
            check_number("robot_seconds", outcome.robot_seconds, unit="s", low=0.0)
            check_whole("env_steps", outcome.env_steps, low=0)
            if outcome.inference_us is not None:
                check_number("inference_us", outcome.inference_us, unit="us", low=0.0)
            _check_once("circle", [cell.key for cell in outcome.cells])
            for cell in outcome.cells:
                check_choice("split", cell.split, SPLITS)
                check_number("radius_mm", cell.radius_mm, unit="mm", low=0.0)
                check_number("speed_mm_s", cell.speed_mm_s, unit="mm/s", low=0.0)
                _check_errors(cell)
        _check_motors([cell for outcome in row.outcomes for cell in outcome.cells])
    except FFGymError as error:
        raise FFGymError(f"{path}: is no result of the leaderboard: {error} {_AGAIN}") from error
    return row


def _check_errors(cell: CircleResult) -> None:
    """Check that errors are sizes, or None."""
    sizes = {name: getattr(cell, name) for name in ("rms_mm", "max_mm", "rms_3d_mm", "max_3d_mm")}
    sizes |= {f"motor_rms_rad[{k}]": value for k, value in enumerate(cell.motor_rms_rad or ())}
    for name, value in sizes.items():
        if value is not None:
            check_number(name, value, low=0.0)


def _check_motors(cells: Sequence[CircleResult]) -> None:
    """Check that all circles have errors of equally many motors."""
    counts = {len(cell.motor_rms_rad) for cell in cells if cell.motor_rms_rad is not None}
    if len(counts) > 1:
        found = " or ".join(map(str, sorted(counts)))
        raise FFGymError(f"motor_rms_rad has {found} numbers, must have one for each motor, the same on all circles.")


def _check_once(what: str, keys: Sequence[object]) -> None:
    for key, count in Counter(keys).items():
        if count > 1:
            raise FFGymError(f"the {what} {key} stands there {count} times.")


def _short(value: Any) -> Any:
    """Round numbers to DIGITS significant digits."""
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    if isinstance(value, dict):
        return {key: _short(entry) for key, entry in value.items()}
    return [_short(entry) for entry in value] if isinstance(value, list | tuple) else value
