"""Command lines of the developers: calibration, benchmarks, generated documentation."""
