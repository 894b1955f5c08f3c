"""Laws that learn, made in a model of the machine, for a diagnosis from tables."""

from collections.abc import Sequence

from ffgym.agents.bspline import ExtendedBSN, StaticBSN
from ffgym.agents.catalogue import make_law
from ffgym.agents.declaration import AgentSetting
from ffgym.agents.lffc import thesis_training
from ffgym.agents.trials import RigTrial
from ffgym.control import FeedForwardLaw
from ffgym.paths import Reference
from ffgym.robot import ModelOptions, RigidArm
from ffgym.simulation import SimulatedRig
from ffgym.simulation.plant import Machine

TRAINING_DT = 0.001
"""Physics step of the trials [s]: a quarter of the time of the built-in robot's step, and errors that differ by 1 %."""

_NETWORKS = {kind.zero(1).name: kind for kind in (StaticBSN, ExtendedBSN)}


def learn_in_model(name: str, machine: Machine, arm: RigidArm, references: Sequence[Reference]) -> FeedForwardLaw:
    """Make a law by its name on a simulated machine; B-spline networks are trained as in the thesis (5.3.2).

    Args:
        name: name of an agent.
        machine: the model that it learns on.
        arm: the robot as the controller knows it.
        references: motions to learn on.

    Raises:
        FFGymError: if there is no such agent.
    """
    rig = SimulatedRig(arm=arm, machine=machine, options=ModelOptions(looks=False, physics_dt=TRAINING_DT))
    trial = RigTrial(rig=rig, n_threads=1)
    if name in _NETWORKS:
        n = arm.robot.n_joints
        return thesis_training(n).learn(_NETWORKS[name].zero(n), references, trial).best
    return make_law(name, AgentSetting(arm=arm, trial=trial, references=references))
