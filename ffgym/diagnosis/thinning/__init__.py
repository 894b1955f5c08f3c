"""Long logs, of which a diagnosis uses stretches."""

from ffgym.diagnosis.thinning.bound import affordable as affordable
from ffgym.diagnosis.thinning.thinned import note_of as note_of
from ffgym.diagnosis.thinning.thinned import thin as thin
from ffgym.diagnosis.thinning.thinned import within_bound as within_bound
