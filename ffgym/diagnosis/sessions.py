"""Short sessions that could tell causes apart, as files that `ffgym record --protocol` runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ffgym.core.toml import toml_value
from ffgym.effects import Effect
from ffgym.robot import RobotDescription
from ffgym.simulation.protocols.load import PROTOCOLS
from ffgym.simulation.protocols.protocol import Protocol


@dataclass(frozen=True, kw_only=True)
class Proposal:
    """A session of two or more motions."""

    name: str
    why: str
    """What it shows, in one phrase."""
    steps: tuple[Mapping[str, Any], ...]
    """Each with `protocol` and settings of that protocol."""

    def protocols(self) -> list[Protocol]:
        """What is recorded."""
        settings = [dict(step) for step in self.steps]
        return [PROTOCOLS[step.pop("protocol")].parse(step) for step in settings]

    def toml(self) -> str:
        """The session as a protocol file."""
        lines = [f"# {self.name}: {self.why}"]
        for step in self.steps:
            lines += ["", "[[step]]", *(f"{name} = {toml_value(value)}" for name, value in step.items())]
        return "\n".join(lines) + "\n"

    def is_advised(self, kinds: Sequence[type[Effect]]) -> bool:
        """Whether one of the effects names one of its protocols as what tells it from its like."""
        advised = {protocol for kind in kinds for protocol in kind.separating_motions}
        return any(step["protocol"] in advised for step in self.steps)


def proposals(robot: RobotDescription, joints: Sequence[str]) -> list[Proposal]:
    """Sessions that move some joints of a robot, or all of them if none is named; each step has another regime.

    Settings are chosen: each session takes about half a minute per joint, and shows its regime in two motions or more,
    so that what one of them says can be checked on another.
    """
    on = {"joints": list(joints)} if joints else {}

    def one(name: str, why: str, protocol: str, *settings: Mapping[str, Any]) -> Proposal:
        return Proposal(name=name, why=why, steps=tuple({"protocol": protocol, **s, **on} for s in settings))

    sessions = [
        one("holds", "load, offset and sag at rest, reached from both sides", "holds", {"poses": 4, "rest": 1.0}),
        one(
            "loads",
            "both directions over the same positions, in poses that load the motors differently",
            "speed_ladder",
            {"speeds": [0.5, 3.0], "longest": 2.0, "poses": 4},
        ),
        one(
            "loops",
            "small loops before friction slides, and slow reversals",
            "slow_triangles",
            {"sizes": [0.5, 2.0, 8.0], "period": 2.0, "periods": 2},
        ),
        one(
            "speeds",
            "constant speeds, slow to fast",
            "speed_ladder",
            {"speeds": [0.05, 0.4, 3.0], "longest": 2.0},
            {"speeds": [0.15, 1.0, 10.0], "longest": 2.0},
        ),
        one(
            "rests",
            "restarts after short and long rests",
            "dwell_restart",
            {"rests": [0.3, 1.0, 4.0]},
            {"rests": [3.0, 0.2, 1.5]},
        ),
        one("sums", "large sums of sines: inertia, gravity, stiffness", "excitation", {"count": 2, "periods": 1}),
        one(
            "vibrations",
            "small fast sines, up to the resonances",
            "excitation",
            {"count": 2, "base": 1.0, "periods": 8, "reach": 0.01},
        ),
        one(
            "warm_up",
            "one motion cold, warming up and warm; let the machine work in between",
            "warm_up",
            {"times": [0.0, 600.0, 1800.0, 5400.0]},
        ),
        one("diagnosis", "every regime in a minute and a half", "diagnosis", {}),
    ]
    if robot.work_area is not None and robot.tool is not None:
        sessions.append(
            Proposal(
                name="circles",
                why="circles of the tool at two speeds",
                steps=({"protocol": "circles", "radii": [0.003]},),
            )
        )
    return sessions
