"""Command line of the benchmark."""

import sys

import tyro

from ffgym.core.errors import FFGymError
from scripts.bench import Config, main

if __name__ == "__main__":
    try:
        main(tyro.cli(Config))
    except FFGymError as error:
        sys.exit(f"bench: error: {error}")
