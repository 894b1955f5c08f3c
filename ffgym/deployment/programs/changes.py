"""Changes of a program by a correction: by how much at most, and where."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array
from ffgym.deployment.plan import SetpointPlan
from ffgym.deployment.programs.points import tool_levers
from ffgym.robot import RigidArm


@dataclass(frozen=True, kw_only=True)
class LargestChange:
    """The largest correction of a joint, or of the tool."""

    size: float
    """[rad or m]."""
    t: float
    """Time in the plan [s]."""
    position: tuple[float, float, float]
    """TCP of the program there, in the world [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ProgramChanges:
    """Corrections of a plan at their largest."""

    joints: tuple[LargestChange, ...]
    """One for each joint."""
    tool: LargestChange
    """Displacement of the tool."""
    share: float
    """Share of the set-points, 0 to 1, that are changed by more than a tenth of the largest displacement."""
    displacement: Array
    """Displacement of the tool at every set-point [m], shape (T,)."""


def measure_changes(plan: SetpointPlan, arm: RigidArm) -> ProgramChanges:
    """Measure what a plan changes in its program."""
    levers = tool_levers(arm, plan.program)
    tcp = arm.tcp_position(plan.program)
    displacement = np.linalg.norm(np.einsum("tij,tj->ti", levers, plan.correction), axis=1)

    def largest(values: Array) -> LargestChange:
        i = int(np.argmax(values))
        x, y, z = (float(part) for part in tcp[i])
        return LargestChange(size=float(values[i]), t=float(plan.t[i]), position=(x, y, z))

    return ProgramChanges(
        joints=tuple(largest(np.abs(column)) for column in plan.correction.T),
        tool=largest(displacement),
        share=float(np.mean(displacement > 0.1 * displacement.max())),
        displacement=displacement,
    )
