"""Friction of motor and gearbox, motor side."""
