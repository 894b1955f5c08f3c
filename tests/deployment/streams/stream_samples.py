"""Robot without physics, for tests of what is sent in real time: it keeps up on a computer with other work."""

import numpy as np

from ffgym.robot import RobotDescription


class FollowingRobot:
    """Robot of an emulator that stands where its last set-point was."""

    def __init__(self, robot: RobotDescription, start: np.ndarray, cycle: float) -> None:
        self.robot, self.position, self.cycle = robot, start, cycle
        self.cycles = self.missed = 0
        self.runs = False

    @property
    def time(self) -> float:
        return self.cycles * self.cycle

    @property
    def planned(self) -> np.ndarray:
        return self.position

    def advance(self, setpoint: np.ndarray | None, torque: np.ndarray | None = None) -> None:
        self.missed += setpoint is None
        self.position = self.position if setpoint is None else setpoint
        self.cycles += 1
