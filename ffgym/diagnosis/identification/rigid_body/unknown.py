"""A robot of unknown masses: bodies by rule of thumb, as heavy as the torque says, for a fit to begin with."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.measures import rms
from ffgym.diagnosis.identification.rigid_body.observation import Filtering, equations_of
from ffgym.diagnosis.identification.rigid_body.terms import (
    BODIES,
    DEFAULT_TERMS,
    ROTOR_INERTIA,
    per_parameter,
    read_description,
    terms_named,
)
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription, RobotDraft
from ffgym.robot.parts import Links
from ffgym.robot.reading.quantity import Quantity

_NO_LENGTH = 0.1
"""Diameter [m] of the balls of an arm whose joints all lie in one point; only one that slides is such an arm."""

_NO_FRICTION = 1e-9
"""Coulomb torque [N m] of a robot whose friction is not known; a description needs one above 0."""

_MASSES = {"links.mass": "kg", "links.com": "m", "links.inertia": "kg m^2"}
"""Entries of bodies, with their units."""


def starting_robot(
    draft: RobotDraft, recordings: Sequence[Recording], filtering: Filtering | None = None
) -> RobotDescription:
    """A robot for `identify_rigid_body`, of a description that knows neither masses nor drives.

    What it lacks is stood in for: links are balls of one density, half-way to the next joint and as thick as that is
    far, or as the links are long on average; rotors are matched to the heaviest that any turns; joints are rigid. The
    density is the one that the recordings ask for.

    Args:
        draft: with geometry, gears and gravity.
        recordings: that the fit will be of.
        filtering: how they are read; None takes the defaults.

    Raises:
        FFGymError: if the draft lacks geometry, gears or gravity, or the recordings tell of no mass.
    """
    robot = draft.description_for("identification")
    known, n = draft.quantities, robot.n_joints
    if "drive.joint_stiffness" not in known:
        robot = replace(robot, drive=replace(robot.drive, joint_stiffness=np.full(n, np.inf)))
    if "friction.coulomb" not in known:  # none to speak of, so that none is taken as known
        little = np.full(n, _NO_FRICTION)
        robot = replace(robot, friction=replace(robot.friction, coulomb=little, static=little, viscous=np.zeros(n)))
    lacks_bodies = any(path not in known for path in _MASSES)
    if lacks_bodies:
        robot = replace(robot, bodies=_balls(robot))
    if "drive.rotor_inertia" not in known:
        # all as heavy as the one that is matched to the most that any turns, half-way through the ranges: too heavy is
        # better than too light, as a rotor of no weight is only 1 away from any reference, relative to it
        middle = robot.kinematics.range.mean(axis=1)
        turned = np.diag(RigidArm(robot).mass_matrix(middle[None])[0])
        heaviest = np.full(n, np.max(turned / robot.drive.gear_ratio**2))
        robot = replace(robot, drive=replace(robot.drive, rotor_inertia=heaviest))
    if not lacks_bodies:
        return robot
    density = _density(robot, recordings, filtering)
    balls = robot.bodies
    robot = replace(robot, bodies=replace(balls, mass=density * balls.mass, inertia=density * balls.inertia))
    if "drive.rotor_inertia" not in known:
        robot = replace(robot, drive=replace(robot.drive, rotor_inertia=density * robot.drive.rotor_inertia))
    # where the numbers come from, for files that replace them
    source = f"rule of thumb: balls of {density:.0f} kg/m^3, half-way to the next joint"
    origins = {
        path: Quantity(
            value=getattr(robot.bodies, path.split(".")[1]), unit=unit, side="link", origin=("chosen",), source=source
        )
        for path, unit in _MASSES.items()
    }
    return replace(robot, quantities=dict(robot.quantities) | origins)


def _balls(robot: RobotDescription) -> Links:
    """Balls of density 1 kg/m^3, each half-way from its joint to the next, none smaller than a middling one."""
    ahead = np.vstack([robot.kinematics.position[1:], np.zeros(3) if robot.tool is None else robot.tool.position])
    far = np.linalg.norm(ahead, axis=1)
    diameter = np.maximum(far, far.mean() if far.any() else _NO_LENGTH)
    mass = np.pi / 6 * diameter**3
    inertia = np.outer(mass * diameter**2 / 10, [1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    return Links(mass=mass, com=ahead / 2, inertia=inertia)


def _density(robot: RobotDescription, recordings: Sequence[Recording], filtering: Filtering | None) -> float:
    """Density of the balls [kg/m^3], beside friction and offsets, by least squares in units of the motors' torque."""
    equations = equations_of(robot, recordings, terms_named(DEFAULT_TERMS), filtering)
    is_mass = per_parameter(robot, equations.terms, lambda term: term in (BODIES, ROTOR_INERTIA))
    described = read_description(robot, equations.terms)
    masses = np.einsum("rkn,k->rn", equations.columns[:, is_mass], described[is_mass])
    columns = np.concatenate([masses[:, None], equations.columns[:, ~is_mass]], axis=1).swapaxes(1, 2)
    size = rms(equations.torque, 0)
    size = np.where(size > 0, size, 1.0)
    rows = (columns / size[:, None])[equations.counts]
    density = float(np.linalg.lstsq(rows, (equations.torque / size)[equations.counts], rcond=None)[0][0])
    if density <= 0:
        raise FFGymError(
            f"The torque of the recordings asks for links of {density:.3g} kg/m^3: they tell of no mass, or torque or "
            f"positions have the wrong sign. Record faster motions that lift the arm, or give links.mass."
        )
    return density
