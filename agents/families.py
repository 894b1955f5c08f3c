"""Modules of this package that declare agents. A new family takes its file, and its name here."""

from ffgym.agents import (
    adapters,
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
    setpoint_rows,
    tensor_bspline,
)
from ffgym.agents.residual import gains, policy

MODULES = (
    baselines,
    lugre,
    bspline,
    tensor_bspline,
    feedback_error,
    narx,
    residual_torque,
    iterative,
    elastic,
    setpoint_rows,
    model,
    adapters,
    gains,
    policy,
    oracle,
)
"""Modules in the order of tables, which `AgentEntry.order` sets."""
