"""What the simulation gets wrong, why, and how sure that is."""

from ffgym.diagnosis.calibration import Calibration as Calibration
from ffgym.diagnosis.diagnose import Examined as Examined
from ffgym.diagnosis.diagnose import diagnose as diagnose
from ffgym.diagnosis.diagnose import examine as examine
from ffgym.diagnosis.prepare import Memory as Memory
from ffgym.diagnosis.result import Diagnosis as Diagnosis
