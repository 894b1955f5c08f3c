"""Command line of mutation testing."""

import sys

import tyro

from ffgym.core.errors import FFGymError
from scripts.mutation import Config, main

if __name__ == "__main__":
    try:
        main(tyro.cli(Config))
    except FFGymError as error:
        sys.exit(f"mutation: error: {error}")
