"""How much a motion will tell of a rigid arm, before it is run."""

from collections.abc import Sequence

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.identification.rigid_body.base import base_parameters, condition_number
from ffgym.diagnosis.identification.rigid_body.link_motion import rigid_motion
from ffgym.diagnosis.identification.rigid_body.observation import Filtering
from ffgym.diagnosis.identification.rigid_body.terms import DEFAULT_TERMS, terms_named
from ffgym.paths import Reference


def excitation_condition(reference: Reference, terms: Sequence[str] = DEFAULT_TERMS) -> float:
    """Condition number of the equations of a motion for the base parameters of its robot; less tells more.

    Columns have unit size, and rows count where a motor moves as in an identification. The robot's masses weigh the
    motors: each motor's torque is in units of its RMS by the description.

    Args:
        reference: the motion.
        terms: what is to be identified.
    """
    robot, parts = reference.robot, terms_named(terms)
    motion = rigid_motion(robot, reference.q, reference.dq, reference.ddq)
    columns = np.concatenate([part for term in parts for part in term.columns(robot, motion)], axis=1)
    described = np.concatenate([term.described(robot) for term in parts])
    size = np.sqrt(np.mean(np.einsum("tkn,k->tn", columns, described) ** 2, axis=0))
    moving = np.abs(motion.motor_dq / robot.drive.gear_ratio) > Filtering().moving
    return condition_number(columns / np.where(size > 0, size, 1.0), moving, base_parameters(robot, parts))


def best_excitation(references: Sequence[Reference], terms: Sequence[str] = DEFAULT_TERMS) -> Reference:
    """The motion with the lowest condition number, e.g. of random ones.

    Raises:
        FFGymError: if there is none to choose from.
    """
    if not references:
        raise FFGymError("There is no motion to choose from: references is empty.")
    return min(references, key=lambda reference: excitation_condition(reference, terms))
