"""Agents of this package as submissions: files and names are recognised, and pass all checks."""

from itertools import pairwise

import numpy as np
import pytest

from ffgym.agents.bspline import StaticBSN
from ffgym.agents.law_files import save_law
from ffgym.agents.residual.actor import Actor, LinearLayer
from ffgym.agents.residual.policy import ResidualPolicy, save_policy
from ffgym.agents.spline_basis import SplineBasis
from ffgym.agents.submission import SUBMITTED, load, resolve_agent
from ffgym.core.errors import FFGymError
from ffgym.robot import load_robot
from tests.leaderboard.submission_samples import ROBOT, judge, packed

MACHINE = f'[machine]\ntitle = "a machine"\nrobot = "{ROBOT}"\n'


@pytest.fixture
def policy_file(tmp_path):
    """A residual policy with random weights, which reacts to the errors it sees."""
    rng = np.random.default_rng(5)
    layers = tuple(
        LinearLayer(weight=(0.2 * rng.normal(size=(b, a))).astype(np.float32), bias=np.zeros(b, dtype=np.float32))
        for a, b in pairwise((15, 8, 1))
    )
    actor = Actor(n_motors=6, layers=layers, activation="tanh", output="clip", factored=True)
    policy = ResidualPolicy(base="lugre_dynamic", actor=actor, memory=1, bound=0.3, action_scale=30.0)
    return save_policy(tmp_path / "policy.npz", policy)


@pytest.fixture
def law_file(tmp_path):
    """A learned law that has learned a little."""
    law = StaticBSN.zero(6, SplineBasis(order=2))
    law.coefficients[:] = 0.01
    return save_law(tmp_path / "law.npz", law)


def test_a_residual_policy_is_accepted(policy_file):
    source, content = resolve_agent(str(policy_file))
    assert (source.kind, source.file) == ("policy", "agent.npz")
    data = packed(source, content).data
    verdict = judge().verify(data)
    assert (verdict.manifest.preview, verdict.manifest.action_scale) == (8, 30.0)
    assert verdict.action_difference == 0.0


def test_a_learned_law_is_told_from_a_residual_policy_and_made(law_file, tmp_path):
    source, content = resolve_agent(str(law_file))
    assert (source.kind, source.law, source.file) == ("law", None, "agent.npz")
    (tmp_path / "agent.npz").write_bytes(content)
    assert load(vars(source), tmp_path, load_robot(ROBOT)).preview == 1


def test_every_law_that_can_be_submitted_by_its_name_is_made_from_the_robot_alone(tmp_path):
    assert set(SUBMITTED) >= {"lugre_static", "lugre_dynamic", "elastic", "model"}
    for name in SUBMITTED:
        source, _ = resolve_agent(name)
        policy = load(vars(source), tmp_path, load_robot(ROBOT))
        assert policy.preview >= 1


def test_a_machine_file_is_packed_with_its_law(tmp_path):
    (tmp_path / "machine.toml").write_text(MACHINE)
    source, content = resolve_agent(f"model:{tmp_path / 'machine.toml'}")
    assert (source.kind, source.law, source.file) == ("law", "model", "agent.toml")
    (tmp_path / "agent.toml").write_bytes(content)
    assert load(vars(source), tmp_path, load_robot(ROBOT)).preview == 4


@pytest.mark.parametrize("name", ["none", "narx", "oracle", "ilc_motor", "ilc_basis", "fitted", "amortised"])
def test_what_learns_or_knows_the_truth_cannot_be_submitted_by_its_name(name):
    with pytest.raises(FFGymError, match="cannot be submitted by its name"):
        resolve_agent(name)


def test_a_source_that_names_a_law_that_learns_is_refused(tmp_path):
    with pytest.raises(FFGymError, match="law = 'narx' must be one of"):
        load({"kind": "law", "law": "narx", "file": None}, tmp_path, load_robot(ROBOT))
