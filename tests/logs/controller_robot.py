"""A two-link arm whose geometry and drives are known, and no more, for logs of controllers."""

from importlib import resources
from pathlib import Path

import numpy as np

from ffgym.robot import load_draft

JOINTS = ("j1", "j2")
GEARS = np.array([118.0, -101.0])
PER_CURRENT = np.array([14.0, 11.0])  # N m/A behind the gearbox
RATED = np.array([2.5, 1.5])  # N m at the motor

DRIVES = """
[drive.gear_ratio]
value = [118.0, -101.0]
unit = "1"
origin = "chosen"
source = "test"
"""
CURRENTS = """
[drive.torque_per_current]
value = [14.0, 11.0]
unit = "N m/A"
side = "link"
origin = "chosen"
source = "test"
"""
RATEDS = """
[drive.rated_torque]
value = [2.5, 1.5]
unit = "N m"
side = "motor"
origin = "chosen"
source = "test"
"""


def described(folder: Path, *tables: str) -> str:
    """Path of a two-link arm of which geometry, gears and these tables are known."""
    tree = (resources.files("ffgym.robot") / "data" / "two_link.toml").read_text(encoding="utf-8")
    head = "\n[".join(
        part for part in tree.split("\n[") if part.startswith(("robot]", "kinematics.", "simulation.gravity", "#"))
    )
    joints = load_draft("two_link").joints
    for old, new in zip(joints, JOINTS, strict=True):
        head = head.replace(f'"{old}"', f'"{new}"')
    path = folder / "arm.toml"
    path.write_text("\n".join([head, *tables]), encoding="utf-8")
    return str(path)
