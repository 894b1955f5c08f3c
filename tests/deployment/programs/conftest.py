"""A plan of a short motion: a line, half a circle and a rest, under elastic feed-forward."""

import pytest

from ffgym import elastic_feedforward
from ffgym.deployment import SetpointPlan, plan_setpoints
from ffgym.paths import load_motion

PROGRAM = r"""MODULE short
CONST robtarget p := [[1300, -200, 600], [0, 0, 1, 0], [-1, 0, -1, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
PROC main()
MoveJ p, v100, fine, tRobot;
MoveL Offs(p, 10, 0, 0), v50, fine, tRobot;
WaitTime 0.6;
MoveC Offs(p, 15, 5, 0), Offs(p, 20, 0, 0), v20, fine, tRobot;
ENDPROC
ENDMODULE
"""


@pytest.fixture(scope="session")
def plan(arm, tmp_path_factory) -> SetpointPlan:
    """Plan of the motion for the six-axis robot."""
    path = tmp_path_factory.mktemp("plan") / "short.mod"
    path.write_text(PROGRAM)
    reference = load_motion(arm, path).reference
    return plan_setpoints(reference, elastic_feedforward(arm.robot), arm=arm, feedforward="program")
