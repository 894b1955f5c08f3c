"""T11: a link that bends, so that what it carries swings by itself."""

from copy import copy
from dataclasses import dataclass
from typing import Any, final

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.effects.parameters import parameter
from ffgym.effects.transmission.flexible_structure import FlexibleStructure
from ffgym.robot import RobotDescription

bend_joint = "{}_bend".format
"""Name of the joint in the MuJoCo model that is the bend of the link of a joint."""

PLACE = 1 / 3
"""Place of the hinge on the way from a joint to the next: a beam with a force at its end is as far away there as one
with this hinge, which has its slope (deflection F l^3 / (3 EI), slope F l^2 / (2 EI))."""

_COPIED = "name type pos axis ref range limited margin stiffness springref damping armature frictionloss group"


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LinkFlexibility(FlexibleStructure):
    r"""A link bends about an axis parallel to that of its joint, between its own mass and all that it carries.

    A motor, the spring of its gearbox, the link, a spring and the rest of the arm are three masses in a row. The hinge
    stands a third of the way to the next joint, after the last joint to the tool. Motors and encoders of links stand
    before it, the tool behind it; under gravity it sags. A link that slides gives way along its axis.

    Reference:
        Moberg, Hanssen (2007), A DAE approach to feedforward control of flexible manipulators, ICRA: joints without
        motors in the extended flexible joint model.
    """

    name = "link_flexibility"
    code = "T11"
    title = "flexibility of a link"
    equation = r"\varphi = c\, (\tau_b - (t_d / c)\, \dot\varphi), \quad x = f(q) + J_b(q)\, \varphi"
    signature = "tool: follows loads that encoders of links do not show; torque: a second resonance of the joint"
    way_in = "a joint without motor in the MuJoCo model, in each link whose compliance is not 0"
    confusable_with = ("T1", "T7", "T8", "T9")
    alike_in_torque = ("T1", "T8")

    compliance: Array = parameter(
        "c, angle of the bend over the torque there",
        unit="rad/(N m)",
        low=0.0,
        high=1e-6,
        minimum=0.0,
        source="chosen: up to half of what the gearboxes of the main axes of large robots give way (2e-6)",
    )

    def check_fits(self, robot: RobotDescription) -> None:
        """Check also that the last link carries a tool that weighs something where it bends.

        Raises:
            FFGymError: if it carries nothing.
        """
        super().check_fits(robot)
        tool = robot.tool
        if self.compliance[-1] > 0 and (tool is None or tool.mass == 0):
            raise FFGymError(
                f"Robot {robot.name!r} has no tool that weighs something, so effect {self.name} of "
                f"{robot.joints[-1]} has nothing to carry. Leave its compliance at 0, or give the robot such a tool."
            )

    def in_model(self, spec: mujoco.MjSpec, robot: RobotDescription) -> None:
        """Give each link that bends one spring-damper joint, before those of the body that it carries."""
        for j in np.flatnonzero(self.compliance).tolist():
            carried, arm, turned = _next_body(spec, robot, j)
            _add_first_joint(
                spec,
                carried,
                name=bend_joint(robot.joints[j]),
                axis=turned.T @ robot.kinematics.axis[j],
                pos=turned.T @ ((PLACE - 1) * arm),
                **self.joint(j, slides=bool(robot.kinematics.is_sliding[j])),
            )


def _next_body(spec: mujoco.MjSpec, robot: RobotDescription, j: int) -> tuple[mujoco.MjsBody, Array, Array]:
    """Find the body that link j carries, its place [m] and its rotation in the frame of that link."""
    if j == robot.n_joints - 1:
        assert robot.tool is not None  # see `check_fits`
        return spec.body("tool"), robot.tool.position, robot.tool.rotation
    link = robot.links[j + 1]
    body = spec.body(f"{link}_rotor") or spec.body(link)  # a rigid joint has no body for its rotor
    return body, robot.kinematics.position[j + 1], np.eye(3)


def _add_first_joint(spec: mujoco.MjSpec, body: mujoco.MjsBody, **joint: Any) -> None:
    """Add a joint that moves the others of a body; MuJoCo takes joints of a body in the order of their making."""
    others = list(body.joints)
    kept = [{name: copy(getattr(other, name)) for name in _COPIED.split()} for other in others]
    for other in others:
        spec.delete(other)
    body.add_joint(**joint)
    for one in kept:
        body.add_joint(**one)
