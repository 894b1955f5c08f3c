"""Pictures of episodes. Nothing here loads OpenGL before a picture is asked for."""

from ffgym.envs.rendering.options import Rendering as Rendering
from ffgym.envs.rendering.options import check_render_mode as check_render_mode
from ffgym.envs.rendering.renderer import EpisodeRenderer as EpisodeRenderer
