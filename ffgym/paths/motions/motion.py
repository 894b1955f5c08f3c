"""What comes out of a motion file or program: a reference, and what is worth knowing about it."""

from dataclasses import dataclass

from ffgym.paths import Reference


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """A joint reference made from moves, a file or a name."""

    reference: Reference
    """Its `robot` is the one it is for: a program may bring its own tool."""
    notes: tuple[str, ...] = ()
    """Where the motion differs from what was asked for, and why, e.g. a stop where a corner cannot be rounded."""
