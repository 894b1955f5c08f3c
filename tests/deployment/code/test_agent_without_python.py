"""A law in C and a policy in ONNX are together the agent of the simulation."""

import ctypes
from dataclasses import replace

import numpy as np
import pytest

from ffgym.agents.artefacts import TRAINED
from ffgym.agents.residual.bases import base_law
from ffgym.agents.residual.policy import load_policy
from ffgym.control import Window
from ffgym.deployment import write_law_code
from ffgym.deployment.code.compiler import compile_c, find_compiler
from ffgym.deployment.code.policy import encode_onnx
from ffgym.leaderboard.evaluation.closed_loop import run_references
from ffgym.paths.motions import load_motion
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import SimulatedRig

onnxruntime = pytest.importorskip("onnxruntime")
STATE = ("past", "residual")


class Machine:
    """A controller that has the law in C and the policy in ONNX, and reads its motors."""

    def __init__(self, folder, data, reference, law, averaged):
        self.averaged = averaged
        compile_c(find_compiler(), [folder / "law.c"], folder / "law.so", "-shared", "-fPIC")
        self.c, self.session = ctypes.CDLL(str(folder / "law.so")), onnxruntime.InferenceSession(data)
        self.windows, self.far = Window.along(reference, law.preview), Window.along(reference, 8)
        size = len(law.initial_memory(self.windows[0]))
        self.state = ctypes.create_string_buffer(8 * size + 8)
        self.c.law_start(self.state)
        shapes = {entry.name: entry.shape for entry in self.session.get_inputs()}
        self.kept = {name: np.zeros(shapes[name]) for name in STATE}
        self.own, self.k = np.zeros((2, 1, 6)), 0

    def decide(self, error, error_rate):
        """Torque of the next sample [N m] from errors of the motors now."""
        k, own, torque = self.k, np.zeros((2, 1, 6)), np.zeros(6)
        window = (self.windows.q[k], self.windows.motor_dq[k], self.windows.motor_ddq[k])
        if self.averaged:
            self.c.law_own_error(self.state, *(place(part) for part in (*window, *own)))
        else:
            self.c.law_instant_error(self.state, *(place(part) for part in own))
        assert self.c.law_step(self.state, *(place(part) for part in (*window, torque))) == 0
        ahead = [1, 2, 4, 8]
        inputs = {
            "error": error,
            "error_rate": error_rate,
            "reference_velocity": self.far.motor_dq[k][None, ahead],
            "reference_acceleration": self.far.motor_ddq[k][None, ahead],
            "law_error": self.own[0],
            "law_error_rate": self.own[1],
            "begins": np.array([k == 0]),
        }
        names = [output.name for output in self.session.get_outputs()]
        found = dict(zip(names, self.session.run(None, inputs | self.kept), strict=True))
        self.kept, self.own, self.k = {name: found[f"{name}_next"] for name in STATE}, own, k + 1
        return torque + found["torque"]


def place(values):
    assert values.flags.c_contiguous
    return values.ctypes.data_as(ctypes.c_void_p)


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
@pytest.mark.slow
@pytest.mark.parametrize("averaged", [True, False])
def test_both_files_give_the_torque_of_the_agent_in_closed_loop(tmp_path, averaged):
    robot = load_robot("irb4600_60_205").with_arm_share(np.full(6, 0.3))
    whole = load_motion(RigidArm(robot), "circles").reference
    reference = replace(whole, **{name: getattr(whole, name)[:250] for name in ("t", "q", "dq", "ddq")}, phases=())
    policy = replace(load_policy(TRAINED / "ppo_elastic" / "any" / "seed_0.npz"), averaged=averaged)
    law = base_law(policy.base, None, robot)
    write_law_code(law, reference, tmp_path / "law")
    machine = Machine(tmp_path / "law", encode_onnx(policy, robot), reference, law, averaged)
    differences = []

    class Compared:
        """The agent of the simulation, beside the machine."""

        def __init__(self, agent, layout):
            self.agent, self.layout = agent, layout

        def predict(self, observation, state=None, starts=None, deterministic=True):
            action, state = self.agent.predict(observation, state, starts, deterministic)
            errors = (self.layout.read(observation, name) for name in ("error", "error_rate"))
            differences.append(np.abs(machine.decide(*errors) - action * self.layout.action_size).max())
            return action, state

    class Logged:
        def __getattr__(self, name):
            return getattr(policy, name)

        def agent(self, robot, layout):
            return Compared(policy.agent(robot, layout), layout)

    run_references(SimulatedRig(arm=RigidArm(robot)), Logged(), [reference])
    assert len(differences) == len(reference.t) - 1
    assert max(differences) < 1e-9
