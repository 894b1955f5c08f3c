from .composition import Motion as Motion
from .composition import compose as compose
from .load import list_motions as list_motions
from .load import load_motion as load_motion
