"""Gymnasium environments: one robot or many, tracking motions under their existing controller."""

from ffgym.envs.circle_path import CirclePathEnv as CirclePathEnv
from ffgym.envs.circle_path import CirclePathVectorEnv as CirclePathVectorEnv
from ffgym.envs.joint_motion import JointMotionEnv as JointMotionEnv
from ffgym.envs.joint_motion import JointMotionVectorEnv as JointMotionVectorEnv
from ffgym.envs.layers import Agent as Agent
from ffgym.envs.layers import History as History
from ffgym.envs.layers import Hold as Hold
from ffgym.envs.layers import Layer as Layer
from ffgym.envs.layers import LowPass as LowPass
from ffgym.envs.layers import Passing as Passing
from ffgym.envs.layers import Residual as Residual
from ffgym.envs.observation import ObservationLayout as ObservationLayout
from ffgym.envs.one_axis import OneAxisEnv as OneAxisEnv
from ffgym.envs.one_axis import OneAxisVectorEnv as OneAxisVectorEnv
from ffgym.envs.recorder import EpisodeRecorder as EpisodeRecorder
from ffgym.envs.rendering import Rendering as Rendering
from ffgym.envs.rewards import FeedbackEffort as FeedbackEffort
from ffgym.envs.rewards import MotorError as MotorError
from ffgym.envs.rewards import PathError as PathError
from ffgym.envs.rewards import Reward as Reward
from ffgym.envs.rewards import Signals as Signals
from ffgym.envs.sensing import Sensing as Sensing
from ffgym.envs.settings import Settings as Settings
from ffgym.envs.stage import Stage as Stage
from ffgym.envs.stage import Transition as Transition
