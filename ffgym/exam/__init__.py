"""Logs with hidden effects, and how answers are marked."""
