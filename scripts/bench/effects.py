"""Physics steps of machines with effects against those of the same robots without."""

import time

import numpy as np

from ffgym.effects import EFFECTS, Effect
from ffgym.robot import RobotDescription, load_robot
from ffgym.simulation.plant import Machine, Plant
from scripts.bench.turns import Ratio, take_turns

STEPS = 400
"""Physics steps of one measurement, 0.1 s."""


def eight_effects(robot: RobotDescription) -> tuple[Effect, ...]:
    """Effects of all kinds of torque, as a diagnosis may find together; two of them have a memory."""
    return (
        EFFECTS["load_friction"].on(robot, share=0.05),
        EFFECTS["asymmetry"].on(robot, coulomb=0.1, viscous=0.1),
        EFFECTS["temperature_friction"].on(robot, viscous=0.5, coulomb=-0.002, breakaway=0.001),
        EFFECTS["dwell_stiction"].on(robot, share=0.2),
        EFFECTS["kinematic_error"].on(robot, amplitude=1e-4),
        EFFECTS["cogging"].on(robot, amplitude=0.02),
        EFFECTS["torque_ripple"].on(robot, share=0.02),
        EFFECTS["torsional_hysteresis"].on(robot, lost_motion=1e-4),
    )


class Holding:
    """Copies of a machine that hold their home, stepped over and over."""

    def __init__(self, machine: Machine, copies: int, threads: int) -> None:
        self._plant = Plant(machine, copies, n_threads=threads)
        robot = machine.robot
        q = robot.work_area.home if robot.work_area is not None else np.zeros(robot.n_joints)
        self._plant.rest(np.tile(q, (copies, 1)))
        self._controls = np.zeros((copies, STEPS, self._plant.model.nu))
        position, _, _ = self._plant.split_controls(self._controls)
        position[:] = robot.drive.motor_angle(q)

    def rate(self) -> float:
        """Physics steps per second of all copies together."""
        began = time.perf_counter()
        self._plant.drive(self._controls)
        return len(self._controls) * STEPS / (time.perf_counter() - began)


def effect_ratios(name: str, repeats: int, threads: int) -> list[Ratio]:
    """What is left of the speed with one effect and with eight, for one machine and for 36."""
    robot, ratios = load_robot(name), []
    for copies in (1, 36):
        nominal = Holding(Machine(robot=robot), copies, threads)
        for count in (1, 8):
            worn = Holding(Machine(robot=robot, effects=eight_effects(robot)[:count]), copies, threads)
            title = f"{copies} machine{'s' * (copies > 1)} with {count} effect{'s' * (count > 1)} / without"
            ratios.append(take_turns(title, worn.rate, nominal.rate, repeats, unit="physics/s"))
    return ratios
