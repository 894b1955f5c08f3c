"""Feed-forward friction compensation on industrial robots: simulation, baselines, learning, diagnosis.

Rooms: `robot` (descriptions, models, kinematics, dynamics), `friction`, `paths`, `control`, `plant`, `simulation`,
`recordings`, `metrics`, `studies`, `report`, `cli`. docs/architecture.md says who may know whom.
"""

from ffgym.errors import FFGymError as FFGymError
from ffgym.version import __version__ as __version__
