"""What a user tells of the UR10e: its drives, and the columns of its files without titles; see its provenance."""

import os
from pathlib import Path

import pytest

needs_data = pytest.mark.skipif(
    not os.environ.get("FFGYM_DATA"), reason="set FFGYM_DATA to the folder with the published recordings"
)

FOLDER = Path(os.environ.get("FFGYM_DATA", "")) / "ur10e"

PER_CURRENT = [14.87, 13.26, 11.13, 10.62, 11.03, 11.47]

DRIVES = f"""
[drive.gear_ratio]
value = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
unit = "1"
origin = "chosen"
source = "not known; torque per current is given behind the gearbox"

[drive.torque_per_current]
value = {PER_CURRENT}
unit = "N m/A"
side = "link"
origin = "sourced"
source = "provenance of the recordings"
"""

COLUMNS = """
[log]
position_side = "link"
torque_semantics = "current"

[file]
names_row = 0

[columns.timestamp]
source = "1"
unit = "s"

[columns."motor.position"]
source = "{number+1}"
unit = "rad"

[columns."motor.effort"]
source = "{number+13}"
unit = "A"
"""

SPEEDS = """
[columns."motor.velocity"]
source = "{number+7}"
unit = "rad/s"
"""
