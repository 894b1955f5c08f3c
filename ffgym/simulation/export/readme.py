"""The README.txt of an exported folder."""

import mujoco

from ffgym.core.version import __version__
from ffgym.recordings import Recording
from ffgym.simulation.export.model import missing_text
from ffgym.simulation.plant import Machine

_MODEL = """\
model.xml      The robot in MuJoCo's MJCF: arm, elastic joints, friction, servos. All numbers have all their digits,
               so that it compiles to the simulated model bit for bit. Keyframe `home` rests in the home pose.
"""

_BINARY = """\
model.mjb      The same, compiled; loads faster, in MuJoCo {mujoco} only.
"""

_MOTION = """\
controls.csv   What goes into data.ctrl, one row per physics step of {physics_dt:g} s and one for the end; motor side.
               Start from the keyframe `start` of the model.
reference.csv  The motion every {control_dt:g} s for a drive: positions, speeds, accelerations, torques (u_ff of the
               rigid arm, u_lff added by the law, u_total their sum). Names of columns have side and unit.
recording.csv  What the simulated robot did, every {record_dt:g} s. Comment lines on top hold a header in JSON.
play.py        Plays controls.csv in plain MuJoCo and compares every row of recording.csv: python play.py
"""


def readme_text(machine: Machine, recording: Recording | None = None, *, binary: bool) -> str:
    """Text that says what each file is; without a recording there is only the model."""
    robot = machine.robot
    lines = [
        robot.title,
        f"Exported by ffgym {__version__}; needs MuJoCo {mujoco.__version__} and numpy, not ffgym.",
        "",
    ]
    parts = [_MODEL]
    if binary:
        parts.append(_BINARY.format(mujoco=mujoco.__version__))
    if recording is not None:
        header = recording.header
        lines[1:1] = [f"Motion: {header.segment}. Feed-forward: {header.meta['feedforward_law']}."]
        parts.append(
            _MOTION.format(
                physics_dt=header.provenance["physics_dt"],
                control_dt=robot.servo.control_dt,
                record_dt=recording.dt,
            )
        )
    if missing := missing_text(machine):
        lines[-1:-1] = [missing]
    return "\n".join(lines) + "\n" + "".join(parts)
