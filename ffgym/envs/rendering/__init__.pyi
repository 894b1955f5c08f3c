from .renderer import EpisodeRenderer as EpisodeRenderer
from .renderer import Rendering as Rendering
from .renderer import check_render_mode as check_render_mode
