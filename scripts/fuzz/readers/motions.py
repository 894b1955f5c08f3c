"""Motions: files of parts, tables, RAPID programs with the modules that they name, and protocols that list motions."""

from functools import cache
from importlib import resources
from pathlib import Path

from ffgym.paths import load_motion
from ffgym.paths.motions.load import parse_motion
from ffgym.paths.motions.table_part import parse_table
from ffgym.paths.rapid.program import Program, load_program, parse_program
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation.protocols.load import load_protocols
from scripts.fuzz.reader import Make, Reader

_ROBOT = "irb4600_60_205"
_PARTS = """
start = [0.0, 0.3490659, 0.1745329, 0.0, 0.5410521, 0.0]

[limits]
joint_acceleration = 2.0

[[part]]
kind = "joints"
to_deg = [0.5, 20.0, 10.0, 0.0, 31.0, 0.0]
speed = 0.05

[[part]]
kind = "wait"
duration = 0.2

[[part]]
kind = "multisine"
amplitude = [0.01, 0.0, 0.0, 0.0, 0.0, 0.0]
frequencies = [1.0, 2.5]
duration = 2.0
"""
_TABLE = "# a table\nt_s,x_mm,y_mm,z_mm\n" + "".join(
    f"{0.02 * k},{1000 + k**2 / 40},0,{700 + k**2 / 90}\n" for k in range(20)
)
_STEPS = """
[[step]]
protocol = "speed_ladder"
joints = ["axis_1", "axis_2"]

[[step]]
motion = "motion.toml"

[[step]]
motion = "circles"
repeats = 2
"""
_GROUP = '<?xml version="1.0"?>\n<Program>\n<Module>main.mod</Module>\n<Module>work.mod</Module>\n</Program>\n'
_MAIN = """MODULE main
  PROC main()
    VAR num k := 0;
    FOR i FROM 1 TO 3 DO
      k := k + 1;
    ENDFOR
    WHILE k > 0 DO
      k := k - 1;
      draw k;
    ENDWHILE
  ENDPROC
ENDMODULE
"""
_WORK = """MODULE work
  PERS tooldata tNozzle := [TRUE, [[100, 0, 273.2], [0.965925826289, 0, 0.258819045103, 0]],
    [8, [45, 0, 122.9], [1, 0, 0, 0], 0.05, 0.05, 0.02]];
  CONST robtarget pHere := [[1300, -200, 600], [0, 0, 1, 0], [-1, 0, -1, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  PROC draw(num k)
    MoveJ pHere, v100, fine, tNozzle;
    MoveL Offs(pHere, 10 * k, 0, 0), v100, z1, tNozzle;
    IF k = 2 THEN
      WaitTime 0.1;
    ELSE
      MoveC Offs(pHere, 8, 8, 0), Offs(pHere, 0, 10, 0), v100, fine, tNozzle;
    ENDIF
  ENDPROC
ENDMODULE
"""


@cache
def _arm() -> RigidArm:
    return RigidArm(load_robot(_ROBOT))


def _text(name: str, text: str) -> Make:
    def make(folder: Path) -> Path:
        (folder / name).write_text(text.strip() + "\n", encoding="utf-8")
        return folder / name

    return make


def _shipped(name: str) -> Make:
    def make(folder: Path) -> Path:
        text = (resources.files("ffgym.paths.motions") / "data" / f"{name}.toml").read_text(encoding="utf-8")
        (folder / "motion.toml").write_text(text, encoding="utf-8")
        return folder / "motion.toml"

    return make


def _program(folder: Path) -> Path:
    (folder / "main.mod").write_text(_MAIN, encoding="utf-8")
    (folder / "work.mod").write_text(_WORK, encoding="utf-8")
    (folder / "cell.pgf").write_text(_GROUP, encoding="utf-8")
    return folder / "cell.pgf"


def _module(folder: Path) -> Path:
    (folder / "one.mod").write_text(_MAIN.replace("ENDMODULE", "") + _WORK.partition("\n")[2], encoding="utf-8")
    return folder / "one.mod"


def _steps(folder: Path) -> Path:
    (folder / "motion.toml").write_text(_PARTS, encoding="utf-8")
    (folder / "steps.toml").write_text(_STEPS, encoding="utf-8")
    return folder / "steps.toml"


def _load(path: Path) -> None:
    load_motion(_arm(), path)


def _run(path: Path) -> None:
    """Read a program, and run it as far as its motion."""
    program: Program = load_program(path)
    program.execute(_arm().robot)


READERS = (
    Reader(
        name="motion",
        use=_load,
        makes=(_text("motion.toml", _PARTS), _shipped("square"), _shipped("sine")),
        covers=(load_motion, parse_motion),
        share=5,
    ),
    Reader(
        name="motion_table", use=_load, makes=(_text("motion.csv", _TABLE),), covers=(load_motion, parse_table), share=4
    ),
    Reader(name="rapid", use=_run, makes=(_module, _program), covers=(load_program, parse_program), share=10),
    Reader(name="rapid_motion", use=_load, makes=(_module,), covers=(load_motion,), share=2),
    Reader(name="protocols", use=load_protocols, makes=(_steps,), covers=(load_protocols,), share=10),
)
