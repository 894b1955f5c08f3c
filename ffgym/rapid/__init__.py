"""RAPID: the subset of ABB's robot language that cutting programs use, from text to moves."""
