"""Short sessions that could tell causes apart (`sessions.toml`), as files that `ffgym record` runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from typing import Any

from ffgym.core.toml import parse_toml, toml_value
from ffgym.effects import Effect
from ffgym.robot import RobotDescription
from ffgym.simulation.protocols.load import PROTOCOLS
from ffgym.simulation.protocols.protocol import Protocol


@dataclass(frozen=True, kw_only=True)
class SessionProposal:
    """A session of two or more motions."""

    name: str
    why: str
    """Purpose, in one phrase."""
    steps: tuple[Mapping[str, Any], ...]
    """Each with `protocol` and settings of that protocol."""

    def protocols(self) -> list[Protocol]:
        """List the protocols of its motions."""
        settings = [dict(step) for step in self.steps]
        return [PROTOCOLS[step.pop("protocol")].parse(step) for step in settings]

    def toml(self) -> str:
        """Write the session as a protocol file."""
        lines = [f"# {self.name}: {self.why}"]
        for step in self.steps:
            lines += ["", "[[step]]", *(f"{name} = {toml_value(value)}" for name, value in step.items())]
        return "\n".join(lines) + "\n"

    def is_advised(self, kinds: Sequence[type[Effect]]) -> bool:
        """Tell whether an effect names one of its protocols to separate it from similar effects."""
        advised = {protocol for kind in kinds for protocol in kind.separating_motions}
        return any(step["protocol"] in advised for step in self.steps)


def propose_sessions(robot: RobotDescription, joints: Sequence[str]) -> list[SessionProposal]:
    """Propose sessions that move some joints of a robot, or all if none is named; each step has another regime."""
    text = (resources.files("ffgym.diagnosis") / "sessions.toml").read_text(encoding="utf-8")
    on = {"joints": list(joints)} if joints else {}
    found = []
    for session in parse_toml(text, "sessions.toml")["session"]:
        of_tool = session.get("moves") == "tool"
        if of_tool and (robot.work_area is None or robot.tool is None):
            continue
        steps = tuple(step if of_tool else step | on for step in session["steps"])
        found.append(SessionProposal(name=session["name"], why=session["why"], steps=steps))
    return found
