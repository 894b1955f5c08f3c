"""Exams of the diagnosis: logs with hidden effects, drawn by seed, in equations that it does not know, and marks."""
