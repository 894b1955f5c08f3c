from .bound import affordable as affordable
from .thinned import note_of as note_of
from .thinned import thin as thin
from .thinned import within_bound as within_bound
