from .errors import FFGymError as FFGymError
from .files import write_text as write_text
from .types import Array as Array
