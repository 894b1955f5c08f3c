"""The command line."""

import sys


def main() -> None:
    """Entry point of the `ffgym` command."""
    from ffgym.cli.main import main as run

    sys.exit(run())
