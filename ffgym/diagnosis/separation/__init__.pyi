from .choose import separating_motion as separating_motion
