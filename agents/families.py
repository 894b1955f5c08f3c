"""The agents of this package: modules that declare some. Adding a family takes its file, and its name here."""

from ffgym.agents import (
    baselines,
    bspline,
    elastic,
    feedback_error,
    iterative,
    lugre,
    model,
    narx,
    oracle,
    residual_torque,
)
from ffgym.agents.residual import policy

MODULES = (
    baselines,
    lugre,
    bspline,
    feedback_error,
    narx,
    residual_torque,
    iterative,
    elastic,
    model,
    policy,
    oracle,
)
"""In the order of tables, which `Entry.order` says."""
