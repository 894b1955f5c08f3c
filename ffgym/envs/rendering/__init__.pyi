from .options import Rendering as Rendering
from .options import check_render_mode as check_render_mode
from .renderer import EpisodeRenderer as EpisodeRenderer
