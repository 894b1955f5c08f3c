"""Claims: passages of pages as they follow from stored results, records and the code, a module for each field."""

from scripts.claims.told import constants, exams, leaderboard, networks, published_robot, session, thesis

__all__ = ["constants", "exams", "leaderboard", "networks", "published_robot", "session", "thesis"]
