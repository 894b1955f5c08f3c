"""Commit of the repository, which stored results name as their origin."""

import subprocess
from pathlib import Path


def describe_commit() -> str:
    """Describe the commit of the repository, with `-dirty` where files differ from it; `unknown` without git."""
    command = ["git", "describe", "--always", "--dirty"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=Path(__file__).parent)
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return done.stdout.strip()
