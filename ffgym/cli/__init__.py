"""The command line."""

import sys


def main() -> None:
    """Entry point of the `ffgym` command."""
    try:
        from ffgym.cli.main import main as run
    except KeyboardInterrupt:  # Ctrl-C while libraries load; nothing has begun
        sys.exit(130)
    sys.exit(run())
