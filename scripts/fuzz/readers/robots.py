"""Robots: descriptions, parameter files, arm files in MJCF and URDF, machine files."""

from importlib import resources
from pathlib import Path

from ffgym.robot import RigidArm, compile_model, load_draft, load_robot, parse_robot
from ffgym.robot.arm_file.read import read_arm
from ffgym.robot.arm_file.shapes import find_mesh
from ffgym.robot.arm_file.urdf import read_urdf
from ffgym.robot.reading.load import with_parameters
from ffgym.robot.reading.parse import parse_draft
from ffgym.simulation.plant.machine_file import (
    is_machine_file,
    known_robot,
    load_machine,
    origins_of,
    parse_climate,
    parse_machine,
    robot_reference,
)
from scripts.fuzz.reader import Make, Reader

_MJCF = """
<mujoco model="arm">
  <compiler angle="radian" autolimits="true"/>
  <default><geom type="capsule" size="0.03"/><joint armature="0.1"/></default>
  <asset><mesh name="cube" vertex="0 0 0  1 0 0  0 1 0  0 0 1" scale="0.1 0.1 0.1"/></asset>
  <worldbody>
    <geom name="base" fromto="0 0 0 0 0 0.3"/>
    <body name="link1" pos="0 0 0.3">
      <inertial pos="0 0 0.1" mass="5" diaginertia="0.1 0.1 0.02"/>
      <joint name="j1" axis="0 0 1" range="-3 3"/>
      <geom fromto="0 0 0 0.4 0 0"/>
      <body name="link2" pos="0.4 0 0" quat="1 0 0 0">
        <joint name="j2" axis="0 1 0" range="-2 2" damping="1"/>
        <geom type="mesh" mesh="cube" mass="2"/>
        <site name="flange" pos="0.3 0 0"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
_URDF = """
<robot name="arm">
  <link name="base"><visual><geometry><box size="0.2 0.2 0.3"/></geometry></visual></link>
  <joint name="j1" type="revolute">
    <parent link="base"/><child link="link1"/><origin xyz="0 0 0.3" rpy="0 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="100" velocity="2"/>
  </joint>
  <link name="link1">
    <inertial><origin xyz="0 0 0.1"/><mass value="5"/>
      <inertia ixx="0.1" iyy="0.1" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0.2 0 0"/><geometry><cylinder radius="0.03" length="0.4"/></geometry>
      <material name="red"><color rgba="1 0 0 1"/></material></visual>
  </link>
  <joint name="j2" type="prismatic">
    <parent link="link1"/><child link="tool"/><origin xyz="0.4 0 0"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.5" effort="100" velocity="0.3"/>
  </joint>
  <link name="tool">
    <inertial><mass value="2"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><sphere radius="0.05"/></geometry></collision>
  </link>
  <transmission name="t1"><joint name="j1"/>
    <actuator name="m1"><mechanicalReduction>100</mechanicalReduction></actuator>
  </transmission>
</robot>
"""
_PARAMETERS = """
[parameters]
robot = "two_link"
title = "other friction"

[friction.viscous]
value = [0.01, 0.02]
unit = "N m s/rad"
side = "motor"
origin = "derived"
source = "fitted"

[servo.position_gain]
value = [5.0, 6.0]
unit = "N m/rad"
side = "motor"
origin = "sourced"
source = "manual"
"""
_MACHINE = """
[machine]
title = "two links that got worse"
robot = "two_link"

[friction.viscous]
value = [0.01, 0.02]
unit = "N m s/rad"
side = "motor"
origin = "derived"
source = "fitted"

[effects.load_friction]
share = { value = 0.06, unit = "1", source = "one number stands for all joints" }

[effects."cogging:slots"]
amplitude = { value = [0.01, 0.0], unit = "N m" }
cycles = { value = 72.0, unit = "1" }

[climate]
ambient = { value = 25.0, unit = "degC" }
rise = { value = [10.0, 5.0], unit = "K" }
time_constant = { value = 1200.0, unit = "s" }
"""


def _built_in(name: str) -> Make:
    def make(folder: Path) -> Path:
        text = (resources.files("ffgym.robot") / "data" / f"{name}.toml").read_text(encoding="utf-8")
        (folder / "robot.toml").write_text(text, encoding="utf-8")
        return folder / "robot.toml"

    return make


def _text(name: str, text: str) -> Make:
    def make(folder: Path) -> Path:
        (folder / name).write_text(text.strip() + "\n", encoding="utf-8")
        return folder / name

    return make


def _described(folder: Path) -> Path:
    """A parameter file with the description that it names."""
    _built_in("two_link")(folder)
    text = _PARAMETERS.replace('title = "other friction"', 'description = "robot.toml"').strip()
    (folder / "numbers.toml").write_text(text + "\n", encoding="utf-8")
    return folder / "numbers.toml"


def _load(path: Path) -> None:
    load_draft(path)
    RigidArm(load_robot(path))


def _compile(path: Path) -> None:
    compile_model(load_robot(path))


def _change(path: Path) -> None:
    with_parameters(load_robot("two_link"), path)


def _load_machine(path: Path) -> None:
    is_machine_file(path)
    load_machine(path)
    known_robot(path)
    robot_reference(path)
    origins_of(path)


_TEXTS = (parse_robot, parse_draft)

READERS = (
    Reader(
        name="robot",
        use=_load,
        makes=(_built_in("two_link"), _built_in("one_axis"), _built_in("irb4600_60_205")),
        covers=(load_robot, load_draft, *_TEXTS),
        share=10,
    ),
    Reader(
        name="robot_in_the_engine",
        use=_compile,
        makes=(_built_in("two_link"), _built_in("ball_screw")),
        covers=(load_robot,),
        share=8,
    ),
    Reader(
        name="parameters", use=_change, makes=(_text("numbers.toml", _PARAMETERS),), covers=(with_parameters,), share=10
    ),
    Reader(name="parameters_of_a_description", use=_load, makes=(_described,), covers=(load_robot,), share=6),
    Reader(name="mjcf", use=read_arm, makes=(_text("arm.xml", _MJCF),), covers=(read_arm,), share=15),
    Reader(
        name="urdf", use=read_arm, makes=(_text("arm.urdf", _URDF),), covers=(read_arm, read_urdf, find_mesh), share=15
    ),
    Reader(
        name="machine",
        use=_load_machine,
        makes=(_text("machine.toml", _MACHINE),),
        covers=(load_machine, known_robot, origins_of, robot_reference, is_machine_file, parse_machine, parse_climate),
        share=15,
    ),
)
