from .camera import Rendering as Rendering
from .camera import check_render_mode as check_render_mode
from .renderer import EpisodeRenderer as EpisodeRenderer
