"""Sums that all statistics are made of."""
