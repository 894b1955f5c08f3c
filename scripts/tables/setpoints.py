"""Elastic feed-forward through set-points on circles: docs/deployment/setpoints.md, in two minutes."""

from collections.abc import Mapping, Sequence

import numpy as np

from ffgym.agents import elastic_feedforward
from ffgym.control import NoCompensation, SetpointChannel, SetpointResponse
from ffgym.paths import RADII, SPEEDS
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import Run, simulate
from ffgym.studies import circle_references, circle_scores
from scripts.tables.page import Contents, markdown

_IGNORED = SetpointResponse()
"""What a sender knows that compensates nothing."""
RESPONSES = {
    "delay 4 ms": SetpointResponse(delay=0.004),
    "delay 8 ms": SetpointResponse(delay=0.008),
    "delay 16 ms": SetpointResponse(delay=0.016),
    "delay 9.3 ms, filter of first order at 20 Hz": SetpointResponse.low_pass(20.0, delay=0.0093),
    "delay 20.3 ms, filter of second order at 20 Hz": SetpointResponse.low_pass(20.0, delay=0.0203, damping=0.71),
    "delay 20.3 ms, filter of second order at 10 Hz": SetpointResponse.low_pass(10.0, delay=0.0203, damping=0.71),
}
"""Responses of controllers, from EGM's to slower ones."""


def channels(
    robot: str = "irb4600_60_205",
    positions: Sequence[str] | None = None,
    speeds: Sequence[float] = SPEEDS,
    radii: Sequence[float] = RADII,
    responses: Mapping[str, SetpointResponse] = RESPONSES,
) -> Contents:
    """Compare channels of elastic feed-forward: mean RMS path error [um] by speed."""
    described = load_robot(robot)
    arm, law = RigidArm(described), elastic_feedforward(described)
    references = circle_references(arm, positions, speeds, radii)
    ways: dict[str, SetpointChannel | None] = {"torques": None, "set-points": SetpointChannel()}
    for name, response in responses.items():
        ways[f"set-points, {name}"] = SetpointChannel(response=response, known=_IGNORED)
        ways[f"set-points, {name}, compensated"] = SetpointChannel(response=response)
    runs = {"no compensation": [Run(reference=each, law=NoCompensation()) for each in references.values()]}
    runs |= {
        name: [Run(reference=each, law=law, channel=channel) for each in references.values()]
        for name, channel in ways.items()
    }
    errors = {}
    for name, each in runs.items():
        means = [np.mean([score.rms_mm for score in circle_scores(one, radii)]) for one in simulate(each, arm=arm)]
        errors[name] = [
            1e3 * float(np.mean([mean for (_, at), mean in zip(references, means, strict=True) if at == speed]))
            for speed in speeds
        ]
    head = ("way to the motors", *(f"{speed * 1e3:g} mm/s" for speed in speeds))
    rows = [(name, *(f"{value:.1f}" for value in each)) for name, each in errors.items()]
    return Contents(parts={"channels": markdown(head, rows)}, numbers=errors)
