"""Measured motors drive a model."""
