"""Largest stable learning rates of B-spline networks: docs/agents/learning_stability.md, predicted in seconds."""

from ffgym.agents import ExtendedBSN, StaticBSN
from ffgym.agents.stability import LearningStability
from ffgym.agents.trials import every_speed
from ffgym.robot import RigidArm, load_robot
from scripts.tables.page import Contents, markdown

ROBOT, AXIS = "irb4600_60_205", "one_axis"


def stability() -> Contents:
    """Largest stable rates of the extended network on the robot by motions and rows, and of both on one axis."""
    arm = RigidArm(load_robot(ROBOT))
    every = every_speed(arm)
    motions = {f"{speed:g} mm/s": [motion] for speed, motion in zip((10, 40, 100), every, strict=True)}
    motions["all three"] = every
    asked = [(name, 0.001) for name in motions] + [(name, 0.004) for name in ("40 mm/s", "100 mm/s")]
    rows = []
    for name, dt in asked:
        network = ExtendedBSN.zero(arm.robot.n_joints)
        rates = LearningStability.of(network, arm, motions[name], record_dt=dt).largest_rate
        rows.append((name, f"{dt * 1e3:g} ms", *(f"{rate:.2f}" for rate in rates)))
    axis = RigidArm(load_robot(AXIS))
    alone = []
    for kind in (StaticBSN, ExtendedBSN):
        networks = [kind.zero(1) for _ in every_speed(axis)]
        pairs = zip(networks, every_speed(axis), strict=True)
        found = [LearningStability.of(each, axis, [motion]).largest_rate[0] for each, motion in pairs]
        alone.append((kind.__name__.removesuffix("BSN").lower(), *(f"{rate:.2f}" for rate in found)))
    return Contents(
        parts={
            "largest rates": markdown(("learned from", "rows", *arm.robot.joints), rows),
            "one axis": markdown(("network", *(motion.name for motion in every_speed(axis))), alone),
        }
    )
