"""What replay and simulation of a machine differ by is no part of an effect of it."""

import numpy as np
import pytest

import ffgym.diagnosis.fit.fit as fit_module
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.refine import correct_bias, fit
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.diagnosis.prepare import prepare
from ffgym.effects import EFFECTS
from ffgym.paths import joint_reference, multisine
from ffgym.robot import ModelOptions
from ffgym.simulation import Resolver, Run, TorqueSensor, simulate
from ffgym.simulation.plant import Machine

TRUE = {"presliding": {"stiffness": 1.5, "damping": 0.0}, "torque_clock": {"latency": 0.006}}


def diagnosed(robot, name):
    """What a diagnosis of a machine with one effect begins with, and the effect as it is."""
    kind, values = EFFECTS[name], {key: np.array(value) for key, value in TRUE[name].items()}
    joint = robot.joints[0] if any(p.per == "joint" for p in kind.parameters().values()) else ""
    true = Hypothesis(kind=kind, joint=joint, source=None, values=values)
    path = multisine([0.0], np.full((2, 1), 8.0), [0.4, 1.1], np.zeros((2, 1)), 6.0, name="sines")
    log = simulate(
        [Run(reference=joint_reference(robot, path))],
        machine=true.on(Machine(robot=robot)),
        options=ModelOptions(looks=False, physics_dt=robot.physics_dt / 8),  # a machine takes no steps
        sensors=(Resolver(bits=16), TorqueSensor(noise=np.array([0.002]))),
        seed=3,
        record_dt=0.004,
        n_threads=1,
    )
    ready = prepare(
        assemble_log(robot, log), Machine(robot=robot), ParameterPrior(share=1e-5), np.random.default_rng(0)
    )
    return ready.problem, true


@pytest.mark.parametrize("name", list(TRUE))
def test_a_size_is_nearer_to_the_truth(name, one_axis):
    setting, true = diagnosed(one_axis, name)
    plain = fit(setting, [true], begun=True)
    better = correct_bias(setting, plain)
    size = next(iter(TRUE[name]))
    off = [abs(float(found.hypotheses[0].values[size]) - TRUE[name][size]) for found in (plain, better)]
    assert better.left < plain.left
    assert off[1] < 0.5 * off[0] or max(off) < 0.02 * TRUE[name][size]


def test_the_replay_of_the_fit_is_not_made_again(one_axis, monkeypatch):
    setting, true = diagnosed(one_axis, "presliding")
    plain, replayed = fit(setting, [true], begun=True), []
    setting.last_replays.clear()  # as where others were replayed since

    def replay(log, machine, *others):
        replayed.extend(float(effect.stiffness[0]) for effect in machine.effects)
        return made(log, machine, *others)

    made = fit_module.replay
    monkeypatch.setattr(fit_module, "replay", replay)
    assert correct_bias(setting, plain).left < plain.left
    assert replayed
    assert float(plain.hypotheses[0].values["stiffness"]) not in replayed


def test_where_nothing_was_found_nothing_changes(one_axis):
    setting, _ = diagnosed(one_axis, "torque_clock")
    nothing = fit(setting, [])
    assert correct_bias(setting, nothing) is nothing
