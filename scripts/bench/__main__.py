"""Command line of the benchmark."""

import tyro

from scripts.bench import Config, main

if __name__ == "__main__":
    main(tyro.cli(Config))
