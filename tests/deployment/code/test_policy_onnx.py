"""Policies in ONNX give the torques that they give in the simulation, from physical readings and with their memory."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from ffgym.agents.residual.actor import LSTM, Actor, LinearLayer
from ffgym.agents.residual.policy import ResidualPolicy
from ffgym.control import ObservationLayout
from ffgym.core.errors import FFGymError
from ffgym.deployment import write_policy_onnx
from ffgym.deployment.code import policy as module
from ffgym.deployment.code.policy import TOLERANCE, check_onnx, encode_onnx
from ffgym.paths.motions import load_motion
from ffgym.robot import RigidArm, load_robot

onnxruntime = pytest.importorskip("onnxruntime")
onnx = pytest.importorskip("onnx")


def layer(rng, outputs, inputs, size=0.5):
    return LinearLayer(
        weight=(size * rng.normal(size=(outputs, inputs))).astype(np.float32),
        bias=(size * rng.normal(size=outputs)).astype(np.float32),
    )


def policy_of(*, memory=1, activation="tanh", output="clip", recurrent=False, base="lugre_dynamic"):
    """A policy for one motor with random weights."""
    rng, features = np.random.default_rng(3), 3 * memory + 12
    lstm = LSTM(inputs=layer(rng, 20, features), hidden=layer(rng, 20, 5)) if recurrent else None
    widths = (5 if recurrent else features, 8, 1)
    actor = Actor(
        n_motors=1,
        layers=tuple(layer(rng, b, a) for a, b in pairwise(widths)),
        activation=activation,
        output=output,
        factored=not recurrent,
        lstm=lstm,
    )
    return ResidualPolicy(base=base, actor=actor, memory=memory, bound=0.6, action_scale=30.0)


@pytest.fixture(scope="module")
def robot():
    return load_robot("one_axis")


@pytest.fixture(scope="module")
def reference(robot):
    whole = load_motion(RigidArm(robot), "sine").reference
    return replace(whole, **{name: getattr(whole, name)[:300] for name in ("t", "q", "dq", "ddq")}, phases=())


KINDS = {
    "tanh": {},
    "relu": {"activation": "relu", "output": "tanh"},
    "memory": {"memory": 4},
    "recurrent": {"recurrent": True},
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_policy_in_onnx_agrees_with_the_simulation_in_closed_loop(kind, robot, reference, tmp_path):
    check = write_policy_onnx(policy_of(**KINDS[kind]), robot, reference, tmp_path / "policy.onnx")
    assert check.decisions == len(reference.t) - 1
    assert check.largest_difference <= TOLERANCE
    onnx.checker.check_model(str(tmp_path / "policy.onnx"), full_check=True)


@pytest.mark.parametrize("kind", KINDS)
def test_a_policy_in_onnx_decides_as_its_agent_on_any_readings_and_forgets_where_a_motion_begins(kind, robot):
    policy, rng = policy_of(**KINDS[kind]), np.random.default_rng(7)
    session = onnxruntime.InferenceSession(encode_onnx(policy, robot), providers=["CPUExecutionProvider"])
    layout = ObservationLayout(robot, policy.preview, policy.action_scale * robot.friction.static)
    agent, state = policy.agent(robot, layout), None
    kept = {i.name: np.zeros(i.shape) for i in session.get_inputs() if i.name in ("past", "residual", "network")}
    names = [output.name for output in session.get_outputs()]
    for k in range(12):
        begins = k in (0, 7)
        observation = rng.normal(size=(1, layout.size)) * rng.choice(
            [0.05, 20.0]
        )  # small, and beyond where it is clipped
        own = (np.zeros((1, 1)),) * 2 if state is None or begins else state.memory.own
        _, state = agent.predict(observation, state, np.array([begins]))
        readings = module._readings(observation, own, agent.composition)
        found = dict(zip(names, session.run(None, {**readings, **kept, "begins": np.array([begins])}), strict=True))
        kept = {name: found[f"{name}_next"] for name in kept}
        assert np.abs(found["torque"] / (policy.bound * robot.friction.static) - state.residual).max() < 1e-12


def test_a_torque_that_is_no_number_is_noticed(robot, reference):
    policy = policy_of()
    model = onnx.load_from_string(encode_onnx(policy, robot))
    scale = policy.bound * robot.friction.static
    (place,) = (x for x in model.graph.initializer if np.array_equal(onnx.numpy_helper.to_array(x), scale))
    place.CopyFrom(onnx.numpy_helper.from_array(np.nan * scale, name=place.name))
    check = check_onnx(model.SerializeToString(), policy, robot, reference)
    assert np.isnan(check.largest_difference)


def test_readings_go_in_with_units_and_the_largest_torque_stands_in_the_file(robot):
    policy = policy_of(recurrent=True)
    model = onnx.load_from_string(encode_onnx(policy, robot))
    shapes = {i.name: [d.dim_value for d in i.type.tensor_type.shape.dim] for i in model.graph.input}
    assert shapes == {
        "error": [1, 1],
        "error_rate": [1, 1],
        "reference_velocity": [1, 4, 1],
        "reference_acceleration": [1, 4, 1],
        "law_error": [1, 1],
        "law_error_rate": [1, 1],
        "past": [1, 1, 3, 1],
        "residual": [1, 1],
        "network": [1, 2, 5],
        "begins": [1],
    }
    assert [o.name for o in model.graph.output] == ["torque", "past_next", "residual_next", "network_next"]
    notes = {entry.key: entry.value for entry in model.metadata_props}
    assert float(notes["largest_torque"]) == 0.6 * robot.friction.static[0]
    assert notes["reference_samples"] == "1, 2, 4, 8"


def test_a_policy_that_differs_from_the_simulation_is_not_written(robot, reference, tmp_path, monkeypatch):
    policy = policy_of()
    first, last = policy.actor.layers
    other = replace(last, bias=last.bias + np.float32(1e-4))
    changed = replace(policy, actor=replace(policy.actor, layers=(first, other)))
    monkeypatch.setattr(module, "encode_onnx", lambda policy, robot, single: encode_onnx(changed, robot, single=single))
    with pytest.raises(FFGymError, match="differs from the simulation by"):
        write_policy_onnx(policy, robot, reference, tmp_path / "policy.onnx")
    assert not [*tmp_path.iterdir()]


def test_numbers_of_32_bits_are_close_or_refused(robot, reference):
    policy = policy_of()
    data = encode_onnx(policy, robot, single=True)
    assert {i.type.tensor_type.elem_type for i in onnx.load_from_string(data).graph.input} == {
        onnx.TensorProto.FLOAT,
        onnx.TensorProto.BOOL,
    }
    assert 1e-12 < check_onnx(data, policy, robot, reference).largest_difference < 1e-3


def test_a_missing_package_is_told_with_its_extra(robot, reference, tmp_path, monkeypatch):
    monkeypatch.setattr(module, "is_installed", lambda name: name != "onnxruntime")
    with pytest.raises(FFGymError, match=r"needs onnxruntime: pip install 'ffgym\[onnx\]'"):
        write_policy_onnx(policy_of(), robot, reference, tmp_path / "policy.onnx")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ppo_elastic", "sac_drives", "recurrent_ppo_elastic", "servo_gains"])
def test_a_trained_policy_agrees_with_the_simulation(name, tmp_path, monkeypatch, capsys):
    from ffgym.cli.main import main

    monkeypatch.chdir(tmp_path)
    assert main(["export", "policy", name, "--json", "policy.json"]) == 0
    assert "largest difference from the simulation" in capsys.readouterr().out
