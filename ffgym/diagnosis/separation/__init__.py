"""What to record next: the motion that tells rival causes apart."""

from ffgym.diagnosis.separation.choose import separating_motion as separating_motion
