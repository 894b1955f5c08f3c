"""Errors of sensors: between the truth and its measurement."""
