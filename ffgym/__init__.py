"""Feed-forward friction compensation on industrial robots: simulation, baselines, learning, diagnosis.

`import ffgym` registers the Gymnasium environments ffgym/CirclePath-v0, ffgym/OneAxis-v0, ffgym/JointMotion-v0 and
ffgym/FollowPath-v0.

Rooms: `robot` (descriptions, models, kinematics, dynamics), `friction`, `paths`, `control`, `plant`, `simulation`,
`recordings`, `metrics`, `studies`, `envs`, `report`, `cli`. docs/architecture.md says who may know whom.
"""

from ffgym.core.errors import FFGymError as FFGymError
from ffgym.core.registration import register as _register
from ffgym.core.version import __version__ as __version__

_register()
