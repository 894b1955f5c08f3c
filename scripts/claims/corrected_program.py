"""Run the corrected program of docs/deployment/programs.md as our reader reads it: a record of `make claims`."""

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import tyro
from scipy.spatial import cKDTree

from ffgym import elastic_feedforward, load_robot
from ffgym.control import SetpointChannel
from ffgym.core.files import write_json
from ffgym.core.types import Array
from ffgym.deployment import plan_setpoints, write_program
from ffgym.paths import load_motion
from ffgym.recordings import Recording
from ffgym.robot import RigidArm
from ffgym.simulation import Run, simulate

_FINER = 100
"""Points between two samples of the path, from which distances are measured."""


@dataclass(frozen=True)
class Config:
    """Run a motion without a correction, with set-points and as a RAPID program."""

    json: Path
    """File of the distances."""


def main(config: Config) -> None:
    """Write durations, RMS and largest distances of the tool from the path."""
    arm = RigidArm(load_robot("irb4600_60_205"))
    reference, law = load_motion(arm, "thesis_circles").reference, elastic_feedforward(arm.robot)
    plan = plan_setpoints(reference, law, arm=arm)
    with TemporaryDirectory() as folder:
        written = write_program(plan, arm, Path(folder) / "program", "rapid", tolerance=1e-5)
        (module,) = (Path(folder) / "program").glob("*.mod")
        program = load_motion(arm, str(module)).reference
    runs = {
        "no correction": Run(reference=reference),
        "set-points": Run(reference=reference, law=law, channel=SetpointChannel()),
        "RAPID program": Run(reference=program),
    }
    path = _refine(arm.tcp_position(reference.q))
    found = {name: _measure(each, path) for name, each in zip(runs, simulate([*runs.values()], arm=arm), strict=True)}
    write_json(config.json, {"ways": found, "from_plan_mm": 1e3 * written.deviation.distance})


def _refine(points: Array) -> Array:
    """Add points on straight lines between those of a path (T, 3)."""
    places = np.arange(_FINER * (len(points) - 1) + 1) / _FINER
    return np.stack([np.interp(places, np.arange(len(points)), column) for column in points.T], axis=1)


def _measure(recording: Recording, path: Array) -> dict[str, float]:
    """Measure the duration [s] and distances of the tool from a path [um], less the sag at its start."""
    tool = recording.vector("tcp.position")
    away = 1e6 * np.asarray(cKDTree(path).query(tool - (tool[0] - path[0]))[0])
    rms = float(np.sqrt(np.mean(away**2)))
    return {"duration_s": float(np.ptp(recording.t)), "rms_um": rms, "largest_um": float(away.max())}


if __name__ == "__main__":
    main(tyro.cli(Config))
