"""The text of a model compiles to the model, bit for bit, and reads well."""

from dataclasses import replace
from itertools import product
from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ffgym.core.errors import FFGymError
from ffgym.robot import ModelOptions, build_spec, builtin_robots, load_robot, mjcf_text, physics_fingerprint
from ffgym.robot.model.mjcf import text
from ffgym.robot.parts import Geom, Mesh
from tests.robot.arm_samples import random_arm
from tests.robot.robot_samples import unusual

OPTIONS = [
    ModelOptions(flexible=flexible, friction=friction, looks=looks, springs=springs, gravity=springs)
    for flexible, friction, looks, springs in product((True, False), repeat=4)
]


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    """MuJoCo writes MUJOCO_LOG.TXT into the working directory when something is wrong."""
    monkeypatch.chdir(tmp_path)


def assert_same_model(spec):
    """Compile the text and the specification and compare every field, then all bytes."""
    written = mujoco.MjModel.from_xml_string(mjcf_text(spec))
    own = spec.compile()
    for name in mujoco.batch.MODEL_FIELDS:
        holder = [model.opt if name.startswith("opt.") else model for model in (own, written)]
        values = [getattr(h, name.removeprefix("opt.")) for h in holder]
        np.testing.assert_array_equal(*values, err_msg=name)
    assert physics_fingerprint(written) == physics_fingerprint(own)


@pytest.mark.parametrize("name", builtin_robots())
def test_every_builtin_robot_is_written_exactly_whatever_is_left_out(name):
    robot = load_robot(name)
    for options in OPTIONS:
        assert_same_model(build_spec(robot, options))


def test_rails_coupled_wrists_and_springs_are_written_exactly(irb4600):
    for options in OPTIONS:
        assert_same_model(build_spec(unusual(irb4600), options))
    assert {"fixed", "spatial"} <= {e.tag for e in ET.fromstring(mjcf_text(build_spec(unusual(irb4600)))).iter()}


def test_servos_without_integral_part_are_written_exactly(irb4600):
    servo = replace(irb4600.servo, integral_gain=np.array([0.0, 1.0, 0.0, 1.0, 0.0, 1.0]))
    assert_same_model(build_spec(replace(irb4600, servo=servo)))


# masses over twelve decades make inertia nearly singular, which MuJoCo tells; the text is exact all the same
@pytest.mark.filterwarnings("ignore:Inertia matrix is too close to singular:UserWarning")
@settings(max_examples=30)
@example(numbers=np.array([1e-6, 1e-6, 189.0, 66.5, 750659.0, 485612.0]))
@given(numbers=arrays(np.float64, (6,), elements=st.floats(1e-6, 1e6)))
def test_any_numbers_of_a_robot_are_written_exactly(irb4600, numbers):
    drive = replace(irb4600.drive, joint_stiffness=numbers * 1e3, gear_ratio=numbers, peak_torque=numbers / 3)
    friction = replace(irb4600.friction, coulomb=numbers, static=numbers * 1.1, viscous=numbers / 7)
    bodies = replace(irb4600.bodies, mass=numbers, com=irb4600.bodies.com / 3, inertia=irb4600.bodies.inertia / 7)
    robot = replace(irb4600, drive=drive, friction=friction, bodies=bodies, physics_dt=1 / 3000)
    assert_same_model(build_spec(robot, ModelOptions(looks=False)))


@settings(max_examples=20)
@given(types=st.lists(st.sampled_from(["hinge", "slide"]), min_size=1, max_size=7), seed=st.integers(0, 2**32 - 1))
def test_any_serial_arm_is_written_exactly(types, seed):
    assert_same_model(build_spec(random_arm(tuple(types), seed)))


def test_meshes_and_turned_shapes_are_written_exactly(one_axis):
    rng = np.random.default_rng(0)
    quaternion = rng.normal(size=4)
    turned = {"body": "load", "end": None, "colour": (0.1, 0.2, 1 / 3, 1.0), "pos": (0.1, 0.2, 1 / 3)}
    turned["rotation"] = tuple((quaternion / np.linalg.norm(quaternion)).tolist())
    faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], dtype=np.int32)
    mesh = Mesh(vertices=rng.normal(size=(4, 3)).astype(np.float32), faces=faces)
    shapes = {"box": (0.1, 0.2, 1 / 7), "ellipsoid": (0.1, 0.2, 1 / 7), "sphere": (1 / 3,), "mesh": ()}
    geoms = [Geom(type=k, size=v, mesh=mesh if k == "mesh" else None, **turned) for k, v in shapes.items()]
    assert_same_model(build_spec(replace(one_axis, geoms=tuple(geoms))))


def test_keyframes_are_written_exactly(one_axis):
    spec = build_spec(one_axis)
    spec.add_key(name="start", qpos=[1 / 3], qvel=[-1 / 7], act=[0.1, 1e-300], ctrl=[-0.0, 2, 1e300])
    assert_same_model(spec)


@given(value=st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_read_back_exactly_and_whole_ones_have_no_point(value):
    written = text(np.array([value]))
    assert float(written) == value
    assert np.signbit(float(written)) == np.signbit(value)
    assert not written.endswith(".0")


def test_zeros_at_the_end_are_left_out_only_where_asked():
    assert text(np.array([2.5, 0.0, 0.0])) == "2.5 0 0"
    assert text(np.array([2.5, 0.0, 0.0]), shortened=True) == "2.5"
    assert text(np.zeros(3), shortened=True) == "0"


def test_the_text_says_what_is_what(irb4600):
    spec = build_spec(irb4600)
    spec.comment = "Robot -- of a test"
    lines = mjcf_text(spec).splitlines()
    assert lines[0] == "<!-- Robot - - of a test -->"
    assert max(len(line) for line in lines if "=" not in line) <= 120
    written = "\n".join(lines)
    for part in (
        '<pid name="j1_servo" gear="120"',
        'kp="61.99" kv="0.8858" ki="617.9"',
        'lugre="69.9787 0.6753 0.5367 0.5634 0.15" input="none"',
        'range="-1.5707963267948966 2.6179938779914944"',
        "link side",
        "motor side",
        "data.ctrl",
    ):
        assert part in written


def test_what_cannot_be_written_is_refused_by_name(irb4600):
    camera = build_spec(irb4600)
    camera.worldbody.add_camera(name="above", pos=[0, 0, 5])
    with pytest.raises(FFGymError, match=r"cannot be written exactly; they change .*ncam"):
        mjcf_text(camera)
    motor = build_spec(irb4600)
    motor.add_actuator(name="fan", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="j1_motor")
    with pytest.raises(FFGymError, match="'fan' is neither a servo"):
        mjcf_text(motor)
    broken = build_spec(irb4600)
    broken.worldbody.add_geom(name="nothing", size=[0, 0, 0])
    with pytest.raises(FFGymError, match="cannot be written as MJCF: Error: size 0 must be positive"):
        mjcf_text(broken)
