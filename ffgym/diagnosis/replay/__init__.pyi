from .channels import predict as predict
from .channels import predict_feedback as predict_feedback
from .channels import predict_tracker as predict_tracker
from .rows import Replay as Replay
from .rows import replay as replay
