"""Columns of springs that are much stiffer or softer than described, by replays on such springs.

Slopes of a stiffness hold as long as swings stay in phase: a spring that is a fifth softer swings at a frequency that
is a tenth lower, and after five swings its slope points elsewhere. What a log shows of it is near that of a replay with
about as soft a spring, from where a fit finds the rest.
"""

from collections.abc import Iterable

import numpy as np

from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.signatures.column import Column
from ffgym.diagnosis.signatures.parts import replayed_parts
from ffgym.diagnosis.signatures.variant import with_effect
from ffgym.effects.transmission.stiffness import JointStiffness

_CHANGES = (-0.24, -0.16, -0.08, 0.08, 0.16, 0.24)
"""Relative changes of a stiffness that are replayed; chosen: between two of them a swing
is less than a third of a turn away from that of one of them, after six swings."""


def stiffness_columns(run: Replay, joints: Iterable[int]) -> list[Column]:
    """Columns of the springs of some `joints`, by their indices; each change is a candidate of its own."""
    found = []
    for j in joints:
        for choice, change in enumerate(_CHANGES, start=1):
            alone = np.zeros(run.robot.n_joints)
            alone[j] = change
            parts = replayed_parts(run, with_effect(run.machine, JointStiffness(change=alone)))
            found.append(
                Column(
                    effect=JointStiffness,
                    joint=run.robot.joints[j],
                    parameter="change",
                    part=None,
                    choice=choice,
                    span=0,
                    shape={},
                    parts={key: rows / change for key, rows in parts.items()},
                )
            )
    return found
