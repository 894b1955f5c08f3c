"""Parameter files of identified numbers, which every robot of that kind accepts, each number with its source."""

from collections.abc import Mapping

import numpy as np

from ffgym.core.toml import single, toml_table
from ffgym.core.types import Array
from ffgym.robot import RobotDescription
from ffgym.robot.reading.load import GROUPS
from ffgym.robot.reading.quantity import Quantity, si_units
from ffgym.robot.reading.rules import RULES


def make_fitted_quantity(
    robot: RobotDescription,
    path: str,
    value: Array,
    source: str,
    origin: tuple[str, ...] = ("fitted",),
    interval: Array | None = None,
) -> Quantity:
    """A number that replaces one of the description, which it keeps as its prior.

    Args:
        robot: whose description is fitted.
        path: the entry, e.g. 'friction.coulomb'.
        value: SI units, on the side on which descriptions keep it.
        source: what it was fitted to, and how.
        origin: 'fitted', for the whole entry or per joint beside 'derived' ones.
        interval: where each number is, shape (..., 2), 0 and inf where that is not known.
    """
    rule, before = RULES[path], robot.quantities.get(path)
    return Quantity(
        value=np.asarray(value, dtype=np.float64),
        unit=", ".join(si_units(rule, rule.side, robot.kinematics.types)),
        side=rule.side,
        origin=origin,
        source=source,
        prior=entry_of(robot, path),
        prior_source=before.source if before is not None else f"description of {robot.name}",
        interval=interval,
    )


def entry_of(robot: RobotDescription, path: str) -> Array:
    """Numbers of one entry of a description, e.g. 'friction.coulomb'."""
    group, name = path.split(".")
    value = getattr(getattr(robot, GROUPS[group]), name)
    # what a description does without is 0
    return np.zeros(robot.n_joints) if value is None else np.asarray(value, dtype=np.float64)


def parameter_text(
    robot: RobotDescription, quantities: Mapping[str, Quantity], title: str, description: str | None = None
) -> str:
    """Text of a parameter file, TOML, with these entries; numbers keep every bit.

    `description` is the path of the robot's description from the folder of the file; None for a built-in robot.
    """
    tables = [toml_table("parameters", {"robot": robot.name, "title": title, "description": description})]
    for path, quantity in quantities.items():
        has_prior = quantity.prior is not None and quantity.prior_source is not None
        entries = {
            "value": quantity.value,
            "unit": single(quantity.unit.split(", ")),
            "side": quantity.side,
            "origin": single(quantity.origin),
            "source": quantity.source,
            "prior": quantity.prior if has_prior else None,
            "prior_source": quantity.prior_source if has_prior else None,
            "interval": quantity.interval,
        }
        tables.append(toml_table(path, entries))
    return "\n\n".join("\n".join(lines) for lines in tables) + "\n"
