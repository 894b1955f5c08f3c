"""The `ffgym` command: options, and a module of work for each subcommand; one-line errors, exit codes.

What a command computes stands in the package of its subject; commands of the repository stand in `scripts`.
"""

import sys


def main() -> None:
    """Entry point of the `ffgym` command."""
    try:
        from ffgym.cli.main import main as run
    except KeyboardInterrupt:  # Ctrl-C while libraries load; nothing has begun
        sys.exit(130)
    sys.exit(run())
