from .calibration import Calibration as Calibration
from .prepare import Memory as Memory
from .procedure import Examined as Examined
from .procedure import diagnose as diagnose
from .procedure import examine as examine
from .result import Diagnosis as Diagnosis
