from .mending import conditioned as conditioned
from .notes import notes_of as notes_of
