"""B-spline networks as the catalogue trains them: as in the thesis, and with the remedies that it proposes.

Thesis 5.5 finds that a network trained at 10 mm/s gains little at 40 mm/s, as weights at speeds that it never met stay
zero, and proposes first weights from a constant friction, and training over several speeds. `trained_with_prior` does
both.
"""

from ffgym.agents.bspline import BSplineNetwork, ExtendedBSN
from ffgym.agents.common.lessons import friction_motions, thesis_motions
from ffgym.agents.common.network import Network
from ffgym.agents.common.trials import Trial
from ffgym.agents.learning.coulomb_prior import CoulombPrior
from ffgym.agents.learning.lffc import LFFC
from ffgym.robot import RigidArm


def thesis_training(n_joints: int) -> LFFC:
    """Rate and iterations of thesis 5.3.1 for one axis, of 5.3.2 for a robot."""
    return LFFC(rate=0.8, iterations=15) if n_joints == 1 else LFFC(rate=0.95, iterations=10)


def trained_as_in_thesis(kind: type[BSplineNetwork], arm: RigidArm, trial: Trial) -> Network:
    """From zero weights on the one motion of the thesis: p1 at 10 mm/s, or the sine of 1 Hz.

    Raises:
        FFGymError: if the robot has neither a work area nor one joint alone.
    """
    n = arm.robot.n_joints
    return thesis_training(n).learn(kind.zero(n), thesis_motions(arm), trial).best


def trained_with_prior(arm: RigidArm, trial: Trial, name: str) -> Network:
    """An extended network from a Coulomb torque, estimated from one more trial, on motions of two speeds.

    The estimate is made on the slow motion of the thesis, where viscous friction and inertia are least.

    Raises:
        FFGymError: if the robot has neither a work area nor one joint alone.
    """
    n = arm.robot.n_joints
    prior = CoulombPrior.estimated(thesis_motions(arm), trial)
    first = ExtendedBSN.zero(n, name=name).filled(prior.torque_at)
    return thesis_training(n).learn(first, friction_motions(arm), trial).best
