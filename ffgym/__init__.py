"""Feed-forward friction compensation on industrial robots: simulation, baselines, learning, diagnosis.

`import ffgym` registers the Gymnasium environments of docs/environments. The public names of this package are loaded
when they are first used; those of each subpackage (`ffgym.robot`, `ffgym.envs`, `ffgym.agents`, ...) stand one level
below. docs/api.md lists both; anything deeper may change.
"""

import lazy_loader

from ffgym.core.registration import register
from ffgym.core.version import __version__ as __version__

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
register()
del register
