"""Protocols by name, from motion files, and from files that list them."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import read_text
from ffgym.core.toml import parse_toml
from ffgym.paths.motions.load import READERS
from ffgym.simulation.protocols.circles import Circles
from ffgym.simulation.protocols.diagnosis import Diagnosis
from ffgym.simulation.protocols.dwell_restart import DwellRestart
from ffgym.simulation.protocols.excitation import Excitation
from ffgym.simulation.protocols.holds import Holds
from ffgym.simulation.protocols.motion_file import MotionFile
from ffgym.simulation.protocols.protocol import Protocol
from ffgym.simulation.protocols.slow_triangles import SlowTriangles
from ffgym.simulation.protocols.speed_ladder import SpeedLadder
from ffgym.simulation.protocols.table_6_1 import Table61
from ffgym.simulation.protocols.warm_up import WarmUp

PROTOCOLS: Mapping[str, type[Protocol]] = MappingProxyType(
    {
        protocol.name: protocol
        for protocol in (
            Diagnosis,
            SpeedLadder,
            Table61,
            SlowTriangles,
            DwellRestart,
            WarmUp,
            Holds,
            Excitation,
            Circles,
        )
    }
)
"""Protocols by what command lines and files call them."""


STEPS = "step"
"""Table of a file that lists protocols; a TOML file without it is a motion file."""


def load_protocols(source: str | Path) -> list[Protocol]:
    """Protocols that a command line names.

    Args:
        source: a name of PROTOCOLS; a motion file (.toml, .csv, .mod); or a TOML file of steps, see docs/protocols.md.

    Raises:
        FFGymError: if there is no such protocol or file, or a step of it makes no sense.
    """
    path = Path(source)
    if path.suffix.lower() not in READERS:
        if path.suffix or path.name != str(source):
            raise FFGymError(f"{source}: a file of motions must end in {', '.join(READERS)}.")
        return [PROTOCOLS[check_choice("protocol", str(source), list(PROTOCOLS))]()]
    if path.suffix.lower() == ".toml":
        tree = parse_toml(read_text(path), str(path))
        if STEPS in tree:
            return _steps(tree, path)
    return [MotionFile(file=path)]


def _steps(tree: Mapping[str, Any], path: Path) -> list[Protocol]:
    """Protocols of a file that lists them."""
    unknown, steps = sorted(set(tree) - {STEPS}), tree[STEPS]
    if unknown:
        raise FFGymError(f"{path}: unknown entries {', '.join(unknown)}. A file of steps has [[{STEPS}]] tables only.")
    if not isinstance(steps, list) or not steps or not all(isinstance(step, dict) for step in steps):
        raise FFGymError(f"{path}: {STEPS} must be tables, each of which begins with [[{STEPS}]].")
    protocols = []
    for i, step in enumerate(steps, start=1):
        try:
            protocols.append(_step(step, path.parent))
        except FFGymError as error:
            raise FFGymError(f"{path}: step {i}: {error}") from error
    return protocols


def _step(step: Mapping[str, Any], folder: Path) -> Protocol:
    """Protocol of one step; files are looked for in `folder`."""
    settings = dict(step)
    protocol, motion = settings.pop("protocol", None), settings.pop("motion", None)
    if (protocol is None) == (motion is None):
        raise FFGymError("a step needs either protocol = a name, or motion = a name or a file.")
    if protocol is not None:
        return PROTOCOLS[check_choice("protocol", protocol, list(PROTOCOLS))].parse(settings)
    if "file" in settings:
        raise FFGymError(f"file = {settings['file']!r} says the same as motion = {motion!r}; leave it out.")
    parsed = MotionFile.parse({**settings, "file": motion})
    return replace(parsed, file=folder / motion) if Path(motion).suffix else parsed
