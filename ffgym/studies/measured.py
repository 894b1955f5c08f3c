"""Published recordings of real machines as ffgym's: they are not part of the package, and lie where FFGYM_DATA says."""

import os
import zipfile
from pathlib import Path

import numpy as np

from ffgym.errors import FFGymError
from ffgym.recordings import Recording
from ffgym.robot import load_robot, log_header
from ffgym.types import Array

DATA_VARIABLE = "FFGYM_DATA"
"""Environment variable with the folder of published recordings."""


def measured_folder() -> Path:
    """Folder of published recordings.

    Raises:
        FFGymError: if the environment variable is not set, or leads to no folder.
    """
    folder = os.environ.get(DATA_VARIABLE, "")
    if not folder or not Path(folder).is_dir():
        raise FFGymError(f"{DATA_VARIABLE} = {folder!r} must be the folder with the published recordings.")
    return Path(folder)


def read_kr300(path: str | os.PathLike[str]) -> Recording:
    """Recording of the KUKA KR 300 R2500 ultra, 250 Hz, with 150 kg on the flange and feed-forward.

    The file holds arrays t, q_mot_deg, qd_mot_deg_s, tau_mot_nm, q_ref_rad, qd_ref_rad_s, qdd_ref_rad_s2, converted
    from data.mat of a run in data/recorded_trajectories. Joint angles are those of `kuka_kr300_r2500` without offset.

    Raises:
        FFGymError: if the file cannot be read or lacks an array.

    Reference:
        github.com/JonasWeigand/Robot_Identification (MIT, (c) 2021 Jonas Weigand); J. Weigand, J. Ulmen, A. Janot,
        M. Ruskowski, real-time nonlinear parameter identification for an industrial robot (2021).
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            data = {name: np.asarray(file[name], dtype=np.float64) for name in _ARRAYS}
    except (OSError, KeyError, ValueError, TypeError, zipfile.BadZipFile) as error:
        raise FFGymError(f"Cannot read {path} as a recording of the KR 300: {error}.") from error
    robot = load_robot("kuka_kr300_r2500")
    columns = {"timestamp": data["t"]}
    for name, (family, factor) in _ARRAYS.items():
        if family:
            columns |= _per_joint(path, family, factor * data[name], robot.joints)
    return Recording(columns, log_header(robot, segment=Path(path).stem))


_DEGREE = np.pi / 180

_ARRAYS = {
    "t": ("", 1.0),
    "q_mot_deg": ("motor.position", _DEGREE),
    "qd_mot_deg_s": ("motor.velocity", _DEGREE),
    "tau_mot_nm": ("motor.effort", 1.0),
    "q_ref_rad": ("reference.position", 1.0),
    "qd_ref_rad_s": ("reference.velocity", 1.0),
    "qdd_ref_rad_s2": ("reference.acceleration", 1.0),
}
"""Arrays of the file, the family that each becomes, and the factor to SI."""


def _per_joint(path: str | os.PathLike[str], family: str, values: Array, joints: tuple[str, ...]) -> dict[str, Array]:
    if values.ndim != 2 or values.shape[1] != len(joints):
        raise FFGymError(f"{family} in {path} has shape {values.shape}, must be (T, {len(joints)}).")
    return {f"{family}.{joint}": values[:, j] for j, joint in enumerate(joints)}
