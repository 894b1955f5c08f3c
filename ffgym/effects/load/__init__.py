"""Loads of the arm: masses, springs, cables."""
