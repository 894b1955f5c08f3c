"""Laws in C99 compute what the simulation computes, in time, or are not written."""

import ctypes
import subprocess
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ffgym.agents.artefacts import TRAINED
from ffgym.agents.bspline import ExtendedBSN
from ffgym.agents.elastic import elastic_law
from ffgym.agents.law_files import load_law
from ffgym.agents.model import model_law
from ffgym.agents.spline_basis import SplineBasis
from ffgym.agents.tensor_bspline import TensorBSN
from ffgym.control import CausalLaw, DynamicLuGreExact, NoCompensation, StaticLuGre, Window
from ffgym.control.lugre_laws import DynamicLuGreEuler
from ffgym.core.errors import FFGymError
from ffgym.deployment import write_law_code
from ffgym.deployment.code.compiler import UNCHECKED, compile_c, find_compiler
from ffgym.deployment.code.law import TOLERANCE
from ffgym.deployment.code.symbols import Symbols, node_of
from ffgym.deployment.code.tracing import TracedBasis, evaluate
from ffgym.paths.motions import load_motion
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation.plant.compiled.tracing import Graph

needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
SIX_AXES = "irb4600_60_205"


def splines(arm):
    basis, rng = SplineBasis(order=3), np.random.default_rng(0)
    return ExtendedBSN(coefficients=rng.normal(size=(arm.robot.n_joints, 2, basis.n_splines)), basis=basis)


def tensor(arm):
    law = TensorBSN.along([load_motion(arm, "circles").reference])
    weights = np.random.default_rng(0).normal(size=law.coefficients.shape)
    return law.with_weights({"coefficients": weights})


def arm_and_motion(robot: str, motion: str = "circles"):
    arm = RigidArm(load_robot(robot))
    return arm, load_motion(arm, motion).reference


@pytest.fixture(scope="module")
def elastic(tmp_path_factory):
    """Folder of elastic feed-forward for the circles, its comparison, and the law and its reference."""
    arm, reference = arm_and_motion(SIX_AXES)
    law, folder = elastic_law(arm), tmp_path_factory.mktemp("elastic") / "law"
    return folder, write_law_code(law, reference, folder, name="mine"), law, reference


LAWS = {
    "static": lambda arm: StaticLuGre(arm.robot.friction),
    "dynamic": lambda arm: DynamicLuGreExact(arm.robot.friction),
    "euler": lambda arm: DynamicLuGreEuler(arm.robot.friction),
    "splines": splines,
    "tensor": lambda arm: tensor(arm),
    "narx": lambda arm: load_law(TRAINED / "narx" / "nominal" / "seed_0.npz"),
    "network": lambda arm: load_law(TRAINED / "mlp_fel" / "nominal" / "seed_0.npz"),
}


@needs_compiler
@pytest.mark.parametrize("kind", LAWS)
def test_a_law_of_six_axes_agrees_with_the_simulation_and_takes_20_us_at_most(kind, tmp_path):
    arm, reference = arm_and_motion(SIX_AXES)
    law = LAWS[kind](arm)
    check = write_law_code(law, reference, tmp_path / "law")
    assert check.agrees
    assert check.largest_difference <= TOLERANCE * np.abs(law.torque(reference)).max()
    assert 0 < check.median_us <= check.worst_us <= check.longest_us
    assert check.worst_us <= 20
    assert sorted(path.name for path in (tmp_path / "law").iterdir()) == ["check.c", "law.c", "law.h", "reference.csv"]


@needs_compiler
def test_elastic_feedforward_of_six_axes_agrees_with_the_simulation_and_takes_20_us_at_most(elastic):
    _, check, law, reference = elastic
    assert check.agrees
    assert check.largest_difference <= TOLERANCE * np.abs(law.torque(reference)).max()
    assert check.largest_own_difference <= TOLERANCE * np.abs(law.own_errors(reference)[0]).max()
    assert check.worst_us <= 20


def of_one_axis():
    return load_robot("one_axis")


def with_coupled_wrist():
    robot, coupling = load_robot(SIX_AXES), np.zeros((6, 6))
    coupling[5, 4], coupling[4, 3], coupling[5, 3] = -1.0, 0.5, 0.2
    return replace(robot, drive=replace(robot.drive, coupling=coupling))


def with_friction_on_the_arm():
    robot = load_robot(SIX_AXES)
    return replace(robot, friction=replace(robot.friction, arm_share=np.linspace(0.1, 0.6, 6)))


@needs_compiler
@pytest.mark.parametrize(
    "make", [of_one_axis, with_coupled_wrist, pytest.param(with_friction_on_the_arm, marks=pytest.mark.slow)]
)
def test_elastic_feedforward_of_other_robots_agrees_with_the_simulation(make, tmp_path):
    robot = make()
    arm = RigidArm(robot)
    whole = load_motion(arm, "sine" if robot.n_joints == 1 else "circles").reference
    parts = {name: getattr(whole, name)[:300] for name in ("t", "q", "dq", "ddq")}
    assert write_law_code(elastic_law(arm), replace(whole, **parts, phases=()), tmp_path / "law").agrees


@needs_compiler
@pytest.mark.slow
def test_feedforward_from_a_machine_with_backlash_has_c_and_from_one_with_hysteresis_has_not(tmp_path):
    arm, reference = arm_and_motion(SIX_AXES)
    backlash = Path(__file__).parents[3] / "docs" / "backlash.toml"
    check = write_law_code(model_law(backlash, arm), reference, tmp_path / "law")
    assert check.agrees
    assert check.worst_us <= 20
    hysteresis = model_law(TRAINED / "model_fitted" / "workcell_thesis" / "seed_0.toml", arm)
    with pytest.raises(FFGymError, match="has no form in C: its step needs a branch"):
        write_law_code(hysteresis, reference, tmp_path / "other")


@pytest.mark.parametrize("order", [1, 2, 3, 4])
@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**9))
def test_splines_in_arithmetic_are_those_of_scipy(order, seed):
    rng = np.random.default_rng(seed)
    basis = SplineBasis(knots=np.cumsum(rng.uniform(0.1, 1.0, size=6)), order=order)
    graph = Graph(1)
    speed = rng.uniform(basis.knots[0] - 0.5, basis.knots[-1] + 0.5, size=7)
    speed[:3] = basis.knots[[0, 2, -1]]
    given = Symbols.of(graph, [graph.make("given", value=("x", 0), fixed=False)])
    values, places = TracedBasis(knots=basis.knots, order=order).active(given)
    nodes = [node_of(graph, part) for array in (values, places) for part in np.asarray(array, dtype=object).flat]
    found = np.array(np.broadcast_arrays(*evaluate(graph, nodes, {"x": speed[:, None]}), speed)[:-1])
    wanted, numbers = basis.active(speed)
    assert np.array_equal(found[order:].T, numbers)
    assert np.abs(found[:order].T - wanted).max() < 1e-12


@needs_compiler
def test_the_check_of_a_folder_compiles_without_a_warning_and_notices_another_number(elastic, tmp_path):
    folder = elastic[0]
    sources = [folder / name for name in ("mine.c", "check.c")]
    compile_c(find_compiler(), sources, tmp_path / "check", "-Wall", "-Wextra", "-pedantic", "-Werror")

    def run(file: Path) -> int:
        return subprocess.run([tmp_path / "check", file], capture_output=True, check=False).returncode

    table = folder / "reference.csv"
    assert run(table) == 0
    lines = table.read_text().splitlines()
    other = tmp_path / "other.csv"
    for changed in (-13, -1):  # a torque, a speed that the law asks for
        numbers = [float(number) for number in lines[500].split(",")]
        numbers[changed] += 1e-7
        other.write_text("\n".join([*lines[:500], ",".join(map(repr, numbers)), *lines[501:]]) + "\n")
        assert run(other) == 1
    numbers = lines[500].split(",")
    numbers[-13] = "nan"
    other.write_text("\n".join([*lines[:500], ",".join(numbers), *lines[501:]]) + "\n")
    assert run(other) == 1
    other.write_text("\n".join(lines[:300]) + "\n")
    assert run(other) == 2


@needs_compiler
def test_a_law_that_needs_no_program_runs_on_any_motion_in_c(tmp_path):
    arm, reference = arm_and_motion(SIX_AXES)
    law = DynamicLuGreExact(arm.robot.friction)
    write_law_code(law, reference, tmp_path / "law")
    assert "for any motion" in (tmp_path / "law" / "law.h").read_text()
    step, state = load(tmp_path / "law", memory=6)
    rng = np.random.default_rng(1)
    memory = np.zeros(6)
    for _ in range(50):
        q, dq, ddq = rng.normal(scale=3.0, size=(3, 2, 6))
        wanted, memory = law.step(memory, Window(q=q, motor_dq=dq, motor_ddq=ddq, dt=reference.robot.servo.control_dt))
        code, torque = step(state, q, dq, ddq)
        assert code == 0
        assert np.abs(torque - wanted).max() <= 1e-12


@needs_compiler
def test_a_law_for_one_program_gives_no_torque_after_its_end(elastic):
    folder, _, law, reference = elastic
    assert "for the program circles alone" in (folder / "mine.h").read_text()
    memory = law.initial_memory(Window.along(reference, law.preview)[0])
    step, state = load(folder, memory=len(memory), name="mine")
    windows = Window.along(reference, law.preview)
    codes, torques = zip(
        *(step(state, windows.q[k], windows.motor_dq[k], windows.motor_ddq[k]) for k in [*range(len(windows.q)), -1]),
        strict=True,
    )
    assert set(codes[:-1]) == {0}
    assert np.abs(np.array(torques[:-1]) - law.torque(reference)[1:]).max() < 1e-9
    assert codes[-1] == 1
    assert not np.any(torques[-1])


def load(folder: Path, memory: int, name: str = "law"):
    """Compiled step of a law as a function of Python, and its state at the start."""
    compile_c(find_compiler(), [folder / f"{name}.c"], folder / "law.so", "-shared", "-fPIC")
    library = ctypes.CDLL(str(folder / "law.so"))

    class State(ctypes.Structure):
        _fields_ = (("memory", ctypes.c_double * memory), ("step", ctypes.c_long))

    state = State()
    getattr(library, f"{name}_start")(ctypes.byref(state))

    def step(state, *window):
        torque = np.full(window[0].shape[-1], np.nan)
        places = [
            np.ascontiguousarray(part).ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for part in (*window, torque)
        ]
        return getattr(library, f"{name}_step")(ctypes.byref(state), *places), torque

    return step, state


@dataclass(frozen=True, eq=False)
class OwnLaw(CausalLaw):
    """Law of a test, whose torque along a reference is what it steps to, but for an error."""

    formula: object
    error: float = 0.0
    name: str = "own"

    @property
    def n_joints(self):
        return 6

    def step(self, memory, window):
        return self.formula(window.motor_dq[..., 1, :]), memory

    def torque(self, reference):
        return super().torque(reference) + self.error


@needs_compiler
def test_a_law_whose_code_differs_from_the_simulation_is_not_written(tmp_path):
    _, reference = arm_and_motion(SIX_AXES)
    write_law_code(OwnLaw(np.tanh), reference, tmp_path / "right")
    with pytest.raises(FFGymError, match="differs from the simulation by 1e-06 N m along circles"):
        write_law_code(OwnLaw(np.tanh, error=1e-6), reference, tmp_path / "wrong")
    assert [path.name for path in tmp_path.iterdir()] == ["right"]


@pytest.mark.parametrize(
    ("formula", "reason"),
    [
        (lambda dq: dq if dq.max() > 0 else -dq, "a branch that depends on"),
        (np.sort, "numpy.sort"),
        (lambda dq: np.asarray(dq, dtype=float), "what symbols cannot do"),
    ],
)
def test_a_law_without_a_form_in_c_is_refused_with_the_reason(formula, reason, tmp_path):
    _, reference = arm_and_motion(SIX_AXES)
    with pytest.raises(FFGymError, match=f"'own' has no form in C.*{reason}.*ffgym export table"):
        write_law_code(OwnLaw(formula), reference, tmp_path / "law")
    assert not [*tmp_path.iterdir()]


def test_a_law_that_does_not_run_sample_by_sample_is_sent_to_tables(tmp_path):
    _, reference = arm_and_motion(SIX_AXES)
    with pytest.raises(FFGymError, match=r"'none' does not run sample by sample.*ffgym export table"):
        write_law_code(NoCompensation(), reference, tmp_path / "law")


def test_without_a_compiler_a_law_is_written_only_unchecked(tmp_path, monkeypatch):
    monkeypatch.setenv("CC", "absent_compiler")
    arm, reference = arm_and_motion(SIX_AXES)
    law = StaticLuGre(arm.robot.friction)
    with pytest.raises(FFGymError, match=r"no C compiler.*--unchecked"):
        write_law_code(law, reference, tmp_path / "law")
    assert not [*tmp_path.iterdir()]
    assert write_law_code(law, reference, tmp_path / "law", checked=False) is None
    assert UNCHECKED in (tmp_path / "law" / "law.h").read_text()


@pytest.mark.parametrize("name", ["Law", "2law", "my-law", "check", ""])
def test_a_name_that_is_none_in_c_is_refused(name, tmp_path):
    arm, reference = arm_and_motion(SIX_AXES)
    with pytest.raises(FFGymError, match="lower-case letters"):
        write_law_code(StaticLuGre(arm.robot.friction), reference, tmp_path / "law", name=name)
