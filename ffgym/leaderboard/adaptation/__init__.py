"""Adaptation: a machine that an adapter has not seen, a budget of motion on it, then the error on other motions."""
