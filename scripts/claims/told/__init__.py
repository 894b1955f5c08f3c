"""Claims: passages of pages as they follow from stored results, records and the code, a module for each field."""

from scripts.claims.told import (
    benchmark,
    calibration,
    constants,
    deployment,
    exams,
    identification,
    leaderboard,
    narx,
    networks,
    physics,
    published_robot,
    rigid_body,
    session,
    streams,
    thesis,
)

__all__ = [
    "benchmark",
    "calibration",
    "constants",
    "deployment",
    "exams",
    "identification",
    "leaderboard",
    "narx",
    "networks",
    "physics",
    "published_robot",
    "rigid_body",
    "session",
    "streams",
    "thesis",
]
