"""Machines that every agent is scored on: the nominal robot, a workcell, and robots drawn by number."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.envs import Sensing
from ffgym.envs.machines import WORKCELL, find_controller, is_workcell, make_rig
from ffgym.leaderboard.tasks import Task, list_tasks
from ffgym.robot import RigidArm, RobotDescription, load_robot
from ffgym.simulation import Rig, Sensor, SimulatedRig
from ffgym.simulation.plant import Machine, PlantDistribution

ROBOT = "irb4600_60_205"
"""Robot of the leaderboard."""
DRIVES_ROBOT = "irb4600_60_205_arm_drives"
"""The same robot with losses behind its springs and drives that are not ideal."""
NOMINAL = "nominal"
"""Plant that equals the nominal model of its controller."""
THESIS_WORKCELL = WORKCELL + "thesis"
"""Workcell of the leaderboard."""
DRAWN_WORKCELL = WORKCELL + "drives-"
"""Prefix of the names of workcells that are drawn by a seed, with real drives and friction behind their springs."""
DRAW = "draw:"
"""Prefix of the names of drawn plants."""
_DRAW_NAME = re.compile(rf"{DRAW}(0|[1-9]\d{{0,8}})")
_DRAWS = 20261122
"""First number of the seeds of drawn plants, so that no training met one of them: trainings have seeds of their own."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TestPlant:
    """A machine under its controller, for laws (a rig) and for agents (an environment)."""

    __test__ = False
    """Mark for pytest: no test."""
    name: str
    rig: Rig
    env_id: str
    """Environment with the same machine."""
    env_arguments: Mapping[str, Any] = field(default_factory=dict)
    """Keyword arguments of the environment."""
    sensors: tuple[Sensor, ...] = ()
    """Sensors of recordings of the environment, as on the rig."""
    truth: RobotDescription | None = None
    """The machine's true parameters; None where they are shut away."""

    def tasks(self, splits: Sequence[str]) -> list[Task]:
        """List the motions of splits."""
        assert self.rig.robot.work_area is not None  # robots of the leaderboard have one
        return list_tasks(splits, list(self.rig.robot.work_area.positions))

    @property
    def machine(self) -> Machine:
        """Machine that is simulated, also where its numbers are hidden."""
        return self.rig.machine or Machine.of(self.rig.robot)

    @property
    def fingerprint(self) -> str:
        """Fingerprint of the physics."""
        return self.rig.fingerprint


def draw_name(number: int) -> str:
    """Return the name of a drawn plant."""
    return f"{DRAW}{number}"


def draw_number(name: str) -> int | None:
    """Return the number in the name of a drawn plant; None for other names. Every plant has one name."""
    found = _DRAW_NAME.fullmatch(name)
    return None if found is None else int(found[1])


@cache
def find_plant(name: str) -> TestPlant:
    """Find a plant by its name: 'nominal', 'workcell:<name or seed>' or 'draw:<number>'."""
    if is_workcell(name):
        cell = replace(make_rig(name), arm=_arm_of(find_controller(name)))
        return TestPlant(
            name=name,
            rig=cell,
            env_id="ffgym/WorkcellCircles-v0",
            env_arguments={"workcell": name},
            sensors=tuple(getattr(cell, "sensors", ())),
        )
    arm, number = _arm_of(ROBOT), draw_number(name)
    machine, truth = None, arm.robot
    arguments: dict[str, Any] = {"sensing": Sensing(encoder_bits=16)}  # by a resolver, as on a workcell
    if number is not None:  # friction, stiffness, masses and payload differ from the nominal ones
        truth = PlantDistribution().draw(arm.robot, np.random.default_rng([_DRAWS, number]))
        machine, arguments["plant"] = Machine.of(truth), truth
    elif name != NOMINAL:
        raise FFGymError(
            f"Unknown plant {name!r}. Available: {NOMINAL}, {WORKCELL}<name or seed>, {DRAW}<number>, e.g. {DRAW}0."
        )
    rig = SimulatedRig(arm=arm, machine=machine, name=name)
    return TestPlant(name=name, rig=rig, env_id="ffgym/CirclePath-v0", env_arguments=arguments, truth=truth)


@cache
def drives_plant() -> TestPlant:
    """Make the machine with drives on which stability margins are measured: the robot of the -v1 environments."""
    rig = SimulatedRig(arm=_arm_of(DRIVES_ROBOT), name="drives")
    arguments = {"robot": DRIVES_ROBOT, "sensing": Sensing(encoder_bits=16)}
    return TestPlant(name="drives", rig=rig, env_id="ffgym/CirclePath-v0", env_arguments=arguments)


@cache
def _arm_of(robot: str) -> RigidArm:
    """Load the arm that controllers of a robot know, one for all plants, so that references are made once."""
    return RigidArm(load_robot(robot))
