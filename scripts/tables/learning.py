"""Largest stable learning rates of B-spline networks: docs/agents/learning_stability.md, predicted in seconds."""

import numpy as np

from ffgym.agents import ExtendedBSN, StaticBSN
from ffgym.agents.changing_motions import ChangingMotions
from ffgym.agents.stability import LearningStability
from ffgym.agents.trials import every_speed
from ffgym.robot import RigidArm, load_robot
from ffgym.studies import sine_references
from scripts.tables.page import Contents, markdown

ROBOT, AXIS = "irb4600_60_205", "one_axis"
CHANGING = {True: 0.8, False: 0.0003}
"""Rates of the table of changing motions: that of the thesis for the normalised update, a slow one for the other."""
FREQUENCIES = (0.5, 1.0, 2.0, 3.0)
"""Frequencies of its sines [Hz]."""


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
            "changing motions": changing(axis),
        }
    )


def changing(axis: RigidArm) -> str:
    """Make the table of motions that change from trial to trial, on one axis."""
    sines = list(sine_references(axis.robot, FREQUENCIES).values())
    rows = []
    for kind in (StaticBSN, ExtendedBSN):
        for normalised, rate in CHANGING.items():
            network = kind.zero(1, normalised=normalised)
            alone = [LearningStability.of(network, axis, [sine], record_dt=0.004).largest_rate[0] for sine in sines]
            study = ChangingMotions.of(network, axis, sines, record_dt=0.004)
            worst, (order,) = study.worst(rate)
            drawn = study.drawn(rate, np.random.default_rng(0))
            name = kind.__name__.removesuffix("BSN").lower()
            rows.append(
                (
                    f"{name}{'' if normalised else ', plain gradient'}",
                    f"{rate:g}",
                    ", ".join(f"{limit:.2g}" if limit < 0.1 else f"{limit:.2f}" for limit in alone),
                    f"{study.bound(rate)[0]:.2f}",
                    f"{worst[0]:.3f}: {', '.join(f'{FREQUENCIES[motion]:g}' for motion in order)} Hz",
                    f"{drawn[0]:.3f}",
                    f"{study.safe_rate[0]:.2g}",
                )
            )
    return markdown(("network", "gamma", "stable alone up to", "at most", "worst order", "drawn order", "safe"), rows)
