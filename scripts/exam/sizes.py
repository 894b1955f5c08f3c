"""Exam on a robot of the user: from what size on would a diagnosis find each effect on that machine?

For each effect, ladders of sizes are asked: one joint, one shape, one machine by chance, and `steps` sizes between
hardly any loudness and the largest plausible one. An effect is found from the size on from which all larger ones of
its ladder are named, or in the tie.
"""

import hashlib
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.core.provenance import versions
from ffgym.diagnosis.excitation import sort_effects
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.diagnosis.residual_rows import describes_low_speed
from ffgym.diagnosis.result import UnjudgedEffect
from ffgym.effects import EFFECTS, Effect
from ffgym.robot import RigidArm, RobotDescription, load_robot
from ffgym.simulation.plant import Climate, Machine
from ffgym.simulation.protocols import load_protocols
from scripts.exam.bench import RECORD_DT, RESOLVER_NOISE, Bench, usual_protocol
from scripts.exam.draw import AMBIENT, RISE, TIME_CONSTANT, Case, draw_machine
from scripts.exam.exams import Exam
from scripts.exam.hidden import drawn
from scripts.exam.loudness import EnergyMeter, OwnTask, limit_effect, record_task
from scripts.exam.marks import Mark
from scripts.exam.report import answers_figure, misses_text
from scripts.exam.tables import Line
from scripts.exam.tasks import ROWS, Question, Row, Truth
from scripts.tables.page import markdown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

QUIETEST, LOUDEST = 0.3, 100.0
"""Energy that the smallest and the largest size of a ladder add, in energies of the noise, as far as plausible sizes
go; chosen: below, no effect can be told from noise, and above, it is found or never."""

CASES, STEPS = 2, 6
"""Ladders of each effect, and sizes of each, where nothing else is asked for."""

_FOUND = ("right", "surplus", "tie")
"""Outcomes in which an effect is found: named, or in the tie."""


@dataclass(frozen=True, kw_only=True)
class SizesExam(Exam):
    """Effects at several sizes on one robot; noise as standard deviations."""

    robot: str
    """Built-in robot, or path of its description."""
    protocol: str | None = None
    """Name or file of the motions; None is the protocol of any diagnosis."""
    resolver_noise: float = RESOLVER_NOISE
    """Motor side [rad]."""
    torque_noise: tuple[float, ...] = ()
    """Motor side [N m], for each joint or one for all; none is 3 % of the Coulomb torque."""
    tracker_noise: float | None = None
    """Noise of each coordinate [m]; None is that of the description."""
    record_dt: float = RECORD_DT
    """Sample period [s]."""
    effects: tuple[str, ...] = ()
    """Effects that are asked for; none is all that the log can show."""
    cases: int = CASES
    """Ladders of each effect, on one joint after the other in an order by chance."""
    steps: int = STEPS
    """Sizes of each ladder."""
    part: ClassVar[str] = "sizes"

    @property
    def prefix(self) -> str:  # type: ignore[override]
        """Beginning of the name of the file of marks: the robot and what its log depends on."""
        return f"sizes_{Path(self.robot).stem}_"

    @property
    def counts(self) -> Mapping[Row, int]:
        """Number of questions: all sizes of all effects."""
        return {"size": self.cases * self.steps * len(self.kinds)}

    @property
    def kinds(self) -> list[type[Effect]]:
        """Effects that are asked for, in the order of the library."""
        able, others = judgeable(self)
        for name in self.effects:
            check_choice("effect", name, list(EFFECTS))
            for one in others:
                if one.effect == name:
                    raise FFGymError(f"No log of this protocol on {self.robot} can show {name}: {one.reason}.")
        return [kind for kind in able if not self.effects or kind.name in self.effects]

    def questions(self, rows: Sequence[str], cases: int | None) -> list[Question]:
        """Numbers that depend neither on how many ladders nor on which effects are asked for."""
        places = [list(EFFECTS).index(kind.name) for kind in self.kinds]
        return [
            ("size", (ladder * len(EFFECTS) + place) * self.steps + step)
            for place in places
            for ladder in range(self.cases)
            for step in range(self.steps)
        ]

    def table(self, marks: Sequence[Mark]) -> list[Line]:
        """Nothing is demanded."""
        return []

    def texts(self, marks: Sequence[Mark]) -> list[str]:
        """Write the table of sizes, the wrong names, and what no log of these motions shows."""
        wrong = [mark for mark in marks if mark.names_wrongly]
        found, (_, others) = detectable_sizes(marks, self.steps), judgeable(self)
        return [sizes_text(found), misses_text(wrong), write_unjudged(others)]

    def picture(self, marks: Sequence[Mark]) -> "Figure":
        """Draw the answers over loudness."""
        return sizes_figure(marks)

    def document(self, marks: Sequence[Mark]) -> dict[str, Any]:
        """Collect the table of sizes for programs."""
        found, (_, others) = detectable_sizes(marks, self.steps), judgeable(self)
        return {"sizes": [asdict(one) for one in found], "not_judgeable": [asdict(one) for one in others]}

    def head(self, seed: int) -> dict[str, Any]:
        """Describe robot, protocol and noise in the first line of the marks."""
        path = Path(self.protocol or "")  # a file, which may change, or a name
        motions = repr(bench_of(self).protocols) + (path.read_text(encoding="utf-8") if path.is_file() else "")
        asked = {name: value for name, value in asdict(self).items() if name not in ("effects", "cases")}
        return {
            "format": "ffgym-exam",
            "exam": "sizes",
            "seed": seed,
            "versions": versions(),
            "asked": asked | {"torque_noise": list(self.torque_noise)},
            "known_effects": len(EFFECTS),
            "physics": self.fingerprint,
            "motions": hashlib.sha256(motions.encode()).hexdigest()[:16],
        }

    def draw_task(self, row: Row, number: int, seed: int) -> OwnTask:
        """Draw a question: an effect at one of its sizes."""
        (ladder, place), step = divmod(number // self.steps, len(EFFECTS)), number % self.steps
        kind, key = list(EFFECTS.values())[place], (seed, ROWS.index("size"), place)
        bench, meter = bench_of(self), build_energy_meter(self)
        joints = places_of(kind, bench.arm.robot)
        joint = joints[np.random.default_rng(key).permutation(len(joints))[ladder % len(joints)]]
        rng = np.random.default_rng((*key, ladder))
        machine, offset = draw_machine(bench.arm.robot, rng)
        largest, energy = limit_effect(meter, drawn(kind, machine.robot, rng, joint))
        case = Case(
            row="size",
            number=number,
            bench=bench,
            audible=bench,
            machine=machine,
            current_offset=offset,
            hidden=(largest.times(share_of(step, self.steps, energy)),),
            loudness=(),
            noise=(*key, ladder, step),
        )
        return record_task(case, meter)


def share_of(step: int, steps: int, energy: float) -> float:
    """Size of one step of a ladder, as a share of the largest plausible one, which adds `energy`."""
    most = min(energy, LOUDEST)
    least = min(QUIETEST, 0.1 * most)
    if most <= 0:  # whatever the size, these motions do not show it
        return (step + 1) / steps
    wanted = least * (most / least) ** (step / max(steps - 1, 1)) if steps > 1 else most
    return float(np.sqrt(wanted / energy))


@cache
def bench_of(exam: SizesExam) -> Bench:
    """The bench that an exam describes.

    Raises:
        FFGymError: if robot, protocol or noise cannot be.
    """
    arm = RigidArm(load_robot(exam.robot))
    robot = arm.robot
    check_whole("--steps", exam.steps, low=1, high=100)
    check_whole("--cases", exam.cases, low=1, high=1000)
    check_number("--resolver-noise", exam.resolver_noise, unit="rad", low=0.0, high=1.0)
    check_number("--record-dt-ms", 1e3 * exam.record_dt, unit="ms", low=0.0, high=1e3, open_low=True)
    if exam.tracker_noise is not None:
        check_number("--tracker-noise", exam.tracker_noise, unit="m", low=0.0, high=1.0)
        if robot.sensors.tracker_period == 0 or robot.tool is None:
            raise FFGymError(f"--tracker-noise has no effect: {robot.name!r} has no tracker. Leave it out.")
    noise = exam.torque_noise
    if len(noise) not in (0, 1, robot.n_joints):
        raise FFGymError(f"--torque-noise has {len(noise)} numbers, must have one, or {robot.n_joints}: one per joint.")
    for value in noise:
        check_number("--torque-noise", value, unit="N m", low=0.0)
    protocols = [usual_protocol(arm)] if exam.protocol is None else load_protocols(exam.protocol)
    return Bench(
        arm=arm,
        protocols=tuple(protocols),
        resolver_noise=exam.resolver_noise,
        torque_noise=np.broadcast_to(np.array(noise, dtype=np.float64), (robot.n_joints,)) if noise else None,
        tracker_noise=exam.tracker_noise,
        record_dt=exam.record_dt,
    )


@cache
def build_energy_meter(exam: SizesExam) -> EnergyMeter:
    """Build the energy meter of the log of an exam, in a machine that warms up."""
    climate = Climate(ambient=AMBIENT, rise=np.array([np.mean(RISE)]), time_constant=TIME_CONSTANT)
    return EnergyMeter(bench_of(exam), climate)


@cache
def judgeable(exam: SizesExam) -> tuple[list[type[Effect]], tuple[UnjudgedEffect, ...]]:
    """Effects that the log can show, and the others with the reason."""
    log, robot = build_energy_meter(exam).log, bench_of(exam).arm.robot
    able, others = sort_effects(log, Machine(robot=robot), ParameterPrior())
    alone = [kind for kind in able if not places_of(kind, robot)]
    reasons = (UnjudgedEffect(effect=kind.name, joint="", reason="it takes two joints") for kind in alone)
    return [kind for kind in able if kind not in alone], (*others, *reasons)


def places_of(kind: type[Effect], robot: RobotDescription) -> list[str]:
    """Joints that can have an effect."""
    if any(known.per == "pair" for known in kind.parameters().values()) and robot.n_joints < 2:
        return []
    able = np.ones(robot.n_joints, dtype=np.bool_)
    if kind.needs_elasticity:
        able &= ~robot.drive.is_rigid
    if kind.at_low_speed:
        able &= describes_low_speed(robot)
    return [joint for joint, can in zip(robot.joints, able, strict=True) if can]


@dataclass(frozen=True, kw_only=True)
class Detectable:
    """One ladder: from what size on an effect is found on a joint."""

    effect: str
    joint: str
    """Empty for the machine as a whole."""
    parameter: str
    unit: str
    found_from: float | None
    """Smallest size from which on all are found; None if the largest is not."""
    not_found_at: float | None
    """Largest size below that, which is not found; None if all are found."""
    loudness: float | None
    """Loudness of the smallest size from which on all are found."""
    largest: float
    """Largest size that was asked."""
    found: int
    """Sizes of the ladder that are found."""
    asked: int
    """Sizes of the ladder."""


def detectable_sizes(marks: Sequence[Mark], steps: int) -> list[Detectable]:
    """Ladders of an exam, in the order of the library and of the ladders."""
    ladders: dict[tuple[int, int], list[Mark]] = defaultdict(list)
    for mark in sorted(marks, key=lambda mark: mark.number):  # the smallest size of a ladder first
        ladder, place = divmod(mark.number // steps, len(EFFECTS))
        ladders[place, ladder].append(mark)
    lines = []
    for _, answers in sorted(ladders.items()):
        found = [mark.outcome in _FOUND for mark in answers]
        first = len(found) - next((k for k, one in enumerate(reversed(found)) if not one), len(found))
        sizes = [size_of(mark.truth[0]) for mark in answers]
        (name, unit, largest), is_found = sizes[-1], first < len(found)
        lines.append(
            Detectable(
                effect=answers[-1].truth[0].effect,
                joint=answers[-1].truth[0].joint,
                parameter=name,
                unit=unit,
                found_from=sizes[first][2] if is_found else None,
                not_found_at=sizes[first - 1][2] if first else None,
                loudness=answers[first].loudness if is_found else None,
                largest=largest,
                found=sum(found),
                asked=len(found),
            )
        )
    return lines


def size_of(truth: Truth) -> tuple[str, str, float]:
    """Parameter that was drawn, its unit, and its distance from nothing; of a vector its length."""
    best = ("", "1", 0.0)
    for name, known in EFFECTS[truth.effect].parameters().items():
        if known.null is None:
            continue
        parts = [value - known.null for key, value in truth.numbers.items() if key.partition(".")[0] == name]
        size = float(np.linalg.norm(parts)) if len(parts) > 1 else float(sum(parts))
        span = max(abs(known.low - known.null), abs(known.high - known.null))
        if not best[0] or abs(size) / span > best[2]:
            best, shown = (name, known.unit, abs(size) / span), size
    return best[0], best[1], shown


def share_of_range(mark: Mark) -> float:
    """Size of a hidden effect, as a share of the largest plausible one of its parameter."""
    name, _, size = size_of(mark.truth[0])
    known = EFFECTS[mark.truth[0].effect].parameters()[name]
    null = known.null or 0.0
    return abs(size) / max(abs(known.low - null), abs(known.high - null))


def sizes_text(found: Sequence[Detectable]) -> str:
    """Markdown table of the size from which on each effect is found."""
    body = []
    for one in found:
        first = f"beyond {one.largest:.3g}" if one.found_from is None else f"{one.found_from:.3g}"
        others = ["-" if value is None else f"{value:.3g}" for value in (one.not_found_at, one.loudness)]
        place = [one.effect, one.joint or "machine", one.parameter, one.unit]
        body.append([*place, first, *others, f"{one.found} of {one.asked}"])
    head = ["effect", "joint", "size", "unit", "found from", "not at", "loudness", "found"]
    return markdown(head, body, aligned=True)


def write_unjudged(others: Sequence[UnjudgedEffect]) -> str:
    """Effects that no such log can show, by reason."""
    by_reason: dict[str, list[str]] = defaultdict(list)
    for one in others:
        by_reason[one.reason].append(one.effect)
    return "\n".join(f"not judgeable: {', '.join(names)}: {reason}" for reason, names in by_reason.items())


def sizes_figure(marks: Sequence[Mark]) -> "Figure":
    """A marker for each answer, effect by effect, over the size as a share of the largest plausible one."""
    rows = {name: [mark for mark in marks if mark.truth[0].effect == name] for name in reversed(list(EFFECTS))}
    return answers_figure(rows, share_of_range, "size, over the largest that is plausible", (0.32, 1.6))
