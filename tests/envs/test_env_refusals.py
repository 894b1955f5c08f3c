"""What is not valid is refused with a message that names the thing, its value and what is valid."""

import gymnasium as gym
import numpy as np
import pytest

from ffgym.control import NoCompensation
from ffgym.core.errors import FFGymError
from ffgym.envs import (
    AbsolutePathError,
    EpisodeRecorder,
    History,
    Hold,
    LowPassAction,
    MotorError,
    RelativePathError,
    ResidualAction,
    Sensing,
)
from tests.envs.env_samples import CIRCLE, FAST_SERVO, JOINTS, ONE_AXIS, OTHER_GEAR, Remembering

ARGUMENTS = {
    CIRCLE: [
        ({"positions": []}, "positions is empty, must hold at least one"),
        ({"positions": "p1"}, r"positions = 'p1' must be a list .* positions=\['p1'\]"),
        ({"positions": (1.2, 0.0, 1.0)}, "must be a list of names or points"),
        ({"positions": np.array([1.2, 0.0, 1.0])}, "must be a list of names or points"),
        ({"positions": 5}, "positions = 5 must be a list"),
        ({"positions": ["p9"]}, "Unknown position 'p9'. Available: p1, p2, p3, p4"),
        ({"positions": ["p1", (9.0, 9.0, 9.0)]}, r"\(9.0000, 9.0000, 9.0000\) m .*not reachable"),
        ({"speeds": []}, "speeds is empty"),
        ({"speeds": [0.01, -0.04]}, r"speed = -0.04 m/s is out of range, must be in \(0.0"),
        ({"speeds": [3.0]}, "speed = 3.0 m/s is too fast for radius = 0.001 m.* at most 0.1571 m/s"),
        ({"radii": []}, "radii is empty"),
        ({"radii": [0.0]}, "radius = 0.0 m is out of range"),
        ({"radii": [[0.001]]}, r"radii has shape \(1, 1\)"),
        ({"order": "random"}, "Unknown order 'random'. Available: listed, one, shuffled"),
        ({"robot": "one_axis"}, "'one_axis' has no work area .* ffgym/OneAxis-v0"),
        ({"robot": "irb"}, "Unknown robot 'irb'. Available"),
        ({"duration": 3.0}, "Unknown keyword argument 'duration'. Available: action_scale"),
        ({"plant": "one_axis"}, "differ in joints"),
    ],
    ONE_AXIS: [
        ({"frequencies": []}, "frequencies is empty"),
        ({"frequencies": [1.0, -1.0]}, r"frequency = -1.0 Hz is out of range"),
        ({"frequencies": ["fast"]}, "frequencies must be numbers"),
        ({"amplitude": 5000.0}, "joint j1 .* must "),
        ({"duration": 0.0}, "duration = 0.0 s is out of range"),
        ({"duration": 1e-5}, "The motion lasts 1e-05 s"),
        ({"duration": 1e12}, "The motion lasts 1e.12 s"),
        ({"robot": "irb4600_60_205"}, "has 6 joints; .* ffgym/JointMotion-v0"),
        ({"robot": 5}, "robot = 5 must be a RobotDescription"),
        ({"plant": FAST_SERVO}, r"differ in servo\.position_gain"),
        ({"plant": OTHER_GEAR}, r"differ in drive\.gear_ratio"),
        ({"plant": "nowhere.toml"}, "Robot description nowhere.toml"),
        ({"preview": -1}, "preview = -1"),
        ({"preview": 1.5}, "preview = 1.5 must be a whole number"),
        ({"horizon": 0}, "horizon = 0.0 control steps is out of range"),
        ({"horizon": -3}, "horizon = -3"),
        ({"horizon": 10**30}, r"horizon = 1e\+30 control steps is out of range"),
        ({"horizon": 2.5}, "horizon = 2.5 must be a whole number"),
        (
            {"reward": "best"},
            "Unknown reward 'best'. Available: feedback_effort, log_rms_error, motor_error, path_error",
        ),
        ({"reward": MotorError}, "reward = .* must be one of .*motor_error.* or a Reward"),
        ({"action_scale": 0.0}, "action_scale = 0.0 must be > 0"),
        ({"action_scale": [1.0, 2.0]}, r"action_scale has shape \(2,\), must be \(1\)"),
        ({"action_scale": np.nan}, "action_scale must be finite"),
        ({"error_limit": 0.0}, "error_limit = 0.0 rad is out of range"),
        ({"sensing": None}, "sensing = None must be of class Sensing, e.g. Sensing"),
        ({"sensing": 16}, "sensing = 16 must be of class Sensing"),
        ({"randomization": True}, "randomization = True must be of class PlantDistribution"),
        ({"recorder": EpisodeRecorder}, r"recorder = .* must be of class EpisodeRecorder, e.g. EpisodeRecorder\(\)"),
        ({"sampling": "all"}, "Unknown sampling 'all'. Available: random, sequence"),
        ({"layers": History(2)}, r"layers = History\(length=2\) must be a list"),
        ({"layers": [History]}, r"layers must hold layers .* History\(8\)"),
        ({"layers": [Hold(2), ResidualAction(NoCompensation())]}, "put ResidualAction below Hold"),
        ({"n_threads": -1}, "n_threads = -1"),
        ({"num_envs": 3}, "num_envs = 3 is for many robots: use gymnasium.make_vec"),
        ({"autoreset_mode": "SameStep"}, "autoreset_mode = 'SameStep' is for many robots"),
    ],
    JOINTS: [
        ({"duration": 0.5}, "duration = 0.5 s must be at least two ramps"),
        ({"peak_speeds": (0.0, 1.0)}, "peak_speeds = .* must be 0 < low <= high"),
        ({"peak_speeds": (2.0, 1.0)}, "peak_speeds = .* must be 0 < low <= high"),
        ({"peak_speeds": 5.0}, "peak_speeds has shape"),
        ({"spread": -0.1}, "spread = -0.1 rad is out of range"),
        ({"sampling": "sequence"}, "random motions cannot"),
    ],
}


@pytest.mark.parametrize(("name", "kwargs", "message"), [(n, k, m) for n, rows in ARGUMENTS.items() for k, m in rows])
def test_arguments_that_make_no_environment_are_refused(name, kwargs, message):
    with pytest.raises(FFGymError, match=message):
        gym.make(name, **kwargs)


@pytest.mark.parametrize(
    ("kwargs", "message"),
    [
        ({"num_envs": 0}, "num_envs = 0"),
        ({"num_envs": 1.5}, "num_envs = 1.5 must be a whole number"),
        ({"num_envs": 2, "autoreset_mode": "Sometimes"}, "Unknown autoreset_mode 'Sometimes'. Available: NextStep"),
    ],
)
def test_arguments_that_make_no_vector_environment_are_refused(kwargs, message):
    with pytest.raises(FFGymError, match=message):
        gym.make_vec(ONE_AXIS, **kwargs)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: History(0), "history length = 0"),
        (lambda: History(1.5), "history length = 1.5 must be a whole number"),
        (lambda: Hold(0), "held steps = 0.0 control steps"),
        (lambda: LowPassAction(0.0), "cutoff = 0.0 Hz"),
        (lambda: ResidualAction(5), "base of a residual must be .* predict, got 5"),
        (lambda: ResidualAction(Remembering), "base of a residual must be .* got <class"),
        (lambda: ResidualAction(NoCompensation), "base of a residual must be .* got <class"),
        (lambda: ResidualAction(NoCompensation(), scale=-1.0), "residual scale = -1.0"),
        (lambda: Sensing(encoder_bits=0), "encoder_bits = 0"),
        (lambda: Sensing(noise=-1.0), "angle noise = -1.0 rad"),
        (lambda: MotorError(effort_weight=-1.0), "effort_weight = -1.0"),
        (lambda: MotorError(stop_steps=-1), "stop_steps = -1"),
        (lambda: AbsolutePathError(scale=0.0), "scale = 0.0 m"),
        (lambda: RelativePathError(scale=0.0), "scale = 0.0 m"),
        (lambda: EpisodeRecorder(keep=-1), "keep = -1"),
        (lambda: EpisodeRecorder(record_dt=0.0), "record_dt = 0.0 s"),
        (lambda: EpisodeRecorder(sensors=[5]), r"sensors = \[5\] must be a list of sensors"),
        (lambda: EpisodeRecorder(sensors=5), "sensors = 5 must be a list of sensors"),
        (lambda: EpisodeRecorder(on_episode=5), "on_episode = 5 must be a function"),
    ],
)
def test_parts_that_make_no_sense_are_refused_when_they_are_made(make, message):
    with pytest.raises(FFGymError, match=message):
        make()


def test_numbers_that_are_whole_are_taken_as_such():
    layers = [History(2.0), Hold(2.0), LowPassAction(3)]
    env = gym.make(ONE_AXIS, preview=1.0, horizon=4.0, layers=layers, sensing=Sensing(encoder_bits=16.0))
    env.reset(seed=np.int64(3))
    assert [env.step([0.0])[3] for _ in range(2)] == [False, True]
