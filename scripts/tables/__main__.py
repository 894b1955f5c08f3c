"""Command line of the tables."""

import tyro

from scripts.tables import Config, main

if __name__ == "__main__":
    main(tyro.cli(Config))
