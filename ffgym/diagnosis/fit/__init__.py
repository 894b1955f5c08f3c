"""Nonlinear fit of hypotheses to a log by replaying the machine that they make."""
