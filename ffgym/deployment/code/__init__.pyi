from .law import CodeCheck as CodeCheck
from .law import write_law_code as write_law_code
