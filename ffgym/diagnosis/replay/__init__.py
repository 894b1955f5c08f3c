"""Measured motors drive a model."""

from ffgym.diagnosis.replay.channels import predicted as predicted
from ffgym.diagnosis.replay.channels import servo_feedback as servo_feedback
from ffgym.diagnosis.replay.channels import tool_path as tool_path
from ffgym.diagnosis.replay.channels import tracked as tracked
from ffgym.diagnosis.replay.replay import Replay as Replay
from ffgym.diagnosis.replay.replay import replay as replay
