from .channels import predicted as predicted
from .channels import servo_feedback as servo_feedback
from .channels import tracked as tracked
from .rows import Replay as Replay
from .rows import replay as replay
