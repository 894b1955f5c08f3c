"""Conditioning: what a log needs before filters and checks, each step told in its header, nothing else changed."""

from ffgym.quality.conditioning.conditioned import conditioned as conditioned
from ffgym.quality.conditioning.notes import notes_of as notes_of
