"""`ffgym export`: the robot as a model that runs in plain MuJoCo."""

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from ffgym.errors import FFGymError
from ffgym.files import write_bytes
from ffgym.plant import Plant
from ffgym.robot import ModelOptions, RobotDescription, build_spec, load_robot


@dataclass(frozen=True)
class Export:
    """Write a robot's complete model (arm, elasticity, friction, servo) as MJCF, or as a binary MuJoCo model."""

    robot: str = "irb4600_60_205"
    """Built-in robot, or a path to a description that ends in .toml."""
    out: Path = Path("robot.xml")
    """File to write: .xml is MJCF, readable, numbers to 6 digits; .mjb is exact, for this MuJoCo version only."""
    flexible: bool = True
    """Elastic joints; no-flexible gives the rigid arm."""
    friction: bool = True
    """LuGre friction."""

    def run(self) -> None:
        """Build the model and write it."""
        options = ModelOptions(flexible=self.flexible, friction=self.friction)
        spec = spec_with_home(load_robot(self.robot), options)
        model = spec.compile()
        if self.out.suffix == ".xml":
            data = spec.to_xml().encode()
        elif self.out.suffix == ".mjb":
            buffer = np.empty(mujoco.mj_sizeModel(model), dtype=np.uint8)
            mujoco.mj_saveModel(model, None, buffer)
            data = buffer.tobytes()
        else:
            raise FFGymError(f"Cannot export to {self.out}: the suffix is {self.out.suffix!r}, must be .xml or .mjb.")
        write_bytes(self.out, data)
        print(
            f"wrote {self.out}: {model.nv} degrees of freedom, {model.nu} controls (position, velocity, torque a motor)"
        )


def spec_with_home(robot: RobotDescription, options: ModelOptions) -> mujoco.MjSpec:
    """The model with a keyframe 'home': at rest in the home pose, springs and integrals carrying gravity."""
    spec = build_spec(robot, options)
    pose = np.zeros(robot.n_joints) if robot.work_area is None else robot.work_area.home
    plant = Plant(robot, 1, options=options)
    plant.rest(pose[None])
    controls = np.zeros(plant.model.nu)
    plant.split_controls(controls)[0][:] = robot.drive.motor_angle(pose)
    spec.add_key(name="home", qpos=plant.batch.qpos[0], act=plant.batch.act[0], ctrl=controls)
    return spec
