"""Write the fingerprints of all environments, after a version was bumped.

python -m scripts.env_fingerprints
"""

from dataclasses import dataclass
from pathlib import Path

import tyro

import ffgym.envs
from ffgym.core.files import write_json
from ffgym.core.registration import ENVIRONMENTS
from ffgym.envs.fingerprint import fingerprint


@dataclass(frozen=True)
class Config:
    """Place of the fingerprints."""

    out: Path = Path(ffgym.envs.__file__).parent / "fingerprints.json"
    """File to write."""


def main(config: Config) -> None:
    """Run every environment and write what it does."""
    write_json(config.out, {name: fingerprint(name) for name in sorted(ENVIRONMENTS)})
    print(f"wrote {config.out}")


if __name__ == "__main__":
    main(tyro.cli(Config))
