"""The workcell: what stands for a real robot, with a truth that only environments and tests come near.

Nothing but `ffgym.envs`, `scripts` and `tests` may import it, so that methods know of it what they measure.
"""

from ffgym.workcell.cell import SealedMachine as SealedMachine
from ffgym.workcell.cell import Workcell as Workcell
from ffgym.workcell.draws import draw as draw
from ffgym.workcell.instances import INSTANCES as INSTANCES
from ffgym.workcell.instances import workcell as workcell
