"""Deviations of the machine's controller from its documentation."""
