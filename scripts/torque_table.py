"""Predicted beside measured motor torque of a recorded robot: what its description is worth.

python -m scripts.torque_table

reads run A of the published recordings of the KUKA KR 300 (folder in the environment variable FFGYM_DATA). From this
run the authors identified friction and payload; run C is one of their validation runs. Speed and acceleration come
from the measured motor angles by a zero-phase filter; samples at rest do not count. Nothing is fitted.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import tyro

from ffgym.core.files import check_writable, write_json, write_text
from ffgym.core.provenance import versions
from ffgym.logs import read_log
from ffgym.published import KR300_FRICTION
from ffgym.report._matplotlib import check_figure, save_figure
from ffgym.report.robot.torque_plot import torque_figure
from ffgym.robot import compile_model, load_robot, physics_fingerprint
from ffgym.studies.measured import measured_folder
from ffgym.studies.torque_prediction import CUTOFF, MOVING, TorqueError, TorquePrediction, predict_torque
from scripts.convergence_table import renewed


@dataclass(frozen=True)
class Config:
    """Torque of the KR 300, predicted and measured."""

    run: str = "A"
    """Run of the recordings, A or C."""
    cutoff: float = CUTOFF
    """Cut-off of the zero-phase filter of the motor angles [Hz]."""
    figure: Path | None = None
    """Picture to draw (.svg, .png, .pdf)."""
    json: Path | None = None
    """Numbers as JSON."""
    write: Path | None = None
    """Markdown file whose table of this run is renewed, docs/torque_prediction.md."""


def main(config: Config) -> TorquePrediction:
    """Print the table; draw and write what is asked for."""
    if config.figure is not None:
        check_figure(config.figure)
    if config.json is not None:
        check_writable(config.json)
    recording = read_log(measured_folder() / "kuka_kr300_2020" / f"{config.run}.npz", "kuka_kr300_2020")
    prediction = predict_torque(load_robot(recording.header.robot), recording, KR300_FRICTION, config.cutoff)
    print(table(prediction))
    if config.figure is not None:
        save_figure(torque_figure(prediction), config.figure)
    if config.json is not None:
        write_json(config.json, _numbers(config, prediction))
    if config.write is not None:
        text = config.write.read_text(encoding="utf-8")
        write_text(config.write, renewed(text, {f"run {config.run}": table(prediction)}))
    return prediction


def table(prediction: TorquePrediction) -> str:
    """Markdown table of measured torque and errors, motor side [N m], one row per joint."""
    names = list(prediction.predicted)
    rows = [
        "| joint | measured RMS | " + " | ".join(names) + " |",
        "|---" * (len(names) + 2) + "|",
    ]
    columns = [prediction.errors(name) for name in names]
    for errors in zip(*columns, strict=True):
        cells = [f"{e.rms_error:.2f}, {e.share:.0%}, {e.max_error:.2f}" for e in errors]
        rows.append(f"| {errors[0].joint} | {errors[0].rms_measured:.2f} | " + " | ".join(cells) + " |")
    return "\n".join(rows)


def _numbers(config: Config, prediction: TorquePrediction) -> Mapping[str, Any]:
    errors: dict[str, tuple[TorqueError, ...]] = {name: prediction.errors(name) for name in prediction.predicted}
    return {
        "config": {"run": config.run, "cutoff_hz": config.cutoff, "moving_rad_s": MOVING},
        "versions": versions(),
        "physics_fingerprint": physics_fingerprint(compile_model(prediction.robot)),
        "errors_nm": {name: [asdict(error) for error in of_joints] for name, of_joints in errors.items()},
    }


if __name__ == "__main__":
    main(tyro.cli(Config))
