"""A submission is accepted if it is what it says, and refused with the reason if it is not."""

import contextlib
import hashlib
import io
import json
import re
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ffgym.agents.submission import LOADERS, load
from ffgym.control import ObservationLayout
from ffgym.core.files import decode_arrays, encode_arrays
from ffgym.leaderboard.evaluation.closed_loop import run_rollouts
from ffgym.leaderboard.evaluation.jobs import score_circles
from ffgym.leaderboard.plants import find_plant
from ffgym.leaderboard.submission import judge as judging
from ffgym.leaderboard.submission import manifest as manifests
from ffgym.leaderboard.submission import python_agent
from ffgym.leaderboard.submission.judge import (
    ACTION_TOLERANCE,
    SCORE_TOLERANCE,
    Judge,
    check_physics,
    check_time,
    controller_of,
)
from ffgym.leaderboard.submission.manifest import (
    ACTIONS,
    AgentSource,
    Refused,
    decode_archive,
    decode_manifest,
    decode_submission,
    digest_of,
)
from ffgym.robot import load_robot
from tests.leaderboard.submission_samples import (
    ABOUT,
    PLAN,
    PYTHON,
    ROBOT,
    SIDE_BY_SIDE,
    agent_file,
    changed,
    judge,
    manifest_of,
    packed,
)

PAGE = Path(__file__).parents[2] / "docs" / "leaderboard" / "submissions.md"


@pytest.fixture(scope="module")
def honest():
    """Submission of a Python agent, which is what it says."""
    return packed().data


def hash_of(data):
    return hashlib.sha256(data).hexdigest()


def code_of_page():
    """The agent that the page shows."""
    code, *_ = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)
    return code


def refusal(data, plan=PLAN):
    with pytest.raises(Refused) as caught:
        judge(plan).verify(data)
    return caught.value


def test_an_honest_agent_is_accepted_with_the_very_actions_and_errors_that_were_logged(honest):
    verdict = judge().verify(honest)
    assert verdict.claims == verdict.manifest.claims
    assert verdict.action_difference == 0.0
    assert 0 < verdict.inference_us < 4000


def test_the_same_agent_gives_the_same_bytes(honest):
    assert packed().data == honest


def test_a_law_is_accepted_and_acts_as_the_law_in_this_process():
    law = AgentSource(kind="law", law="lugre_dynamic")
    data = packed(law).data
    verdict = judge().verify(data)
    assert set(verdict.manifest.files) == {ACTIONS}
    here = load({"kind": "law", "law": "lugre_dynamic", "file": None}, PAGE, load_robot(ROBOT))
    ((flight,),) = run_rollouts(find_plant("nominal"), [here], PLAN["nominal"])
    assert np.allclose(decode_arrays(decode_archive(data)[ACTIONS])["nominal_0"], flight.actions, rtol=0, atol=1e-7)
    (cell,) = score_circles(PLAN["nominal"][0], flight.recording)
    assert cell.rms_mm == pytest.approx(verdict.claims[0].rms_mm, rel=1e-4)


def test_the_agent_of_the_page_has_ten_lines_and_is_accepted():
    code = code_of_page()
    assert len([line for line in code.splitlines() if line.strip()]) == 10
    assert judge().verify(packed(content=code.encode()).data).action_difference == 0.0


class Noisy:
    """An agent that reads every observation wrong in its seventh digit; `ffgym.control.Agent`."""

    def __init__(self, agent, size):
        self.agent, self.size, self.rng = agent, size, np.random.default_rng(0)

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        wrong = observation * (1 + self.size * self.rng.standard_normal(observation.shape))
        return self.agent.predict(wrong, state, episode_start, deterministic)


def test_tolerances_are_far_above_what_rounding_makes_of_a_feedback(tmp_path):
    (tmp_path / "agent.py").write_text(code_of_page())
    policy = python_agent.load({"file": "agent.py"}, tmp_path, load_robot(ROBOT))
    tasks = PLAN["nominal"]
    layout = ObservationLayout(load_robot(ROBOT), 1, policy.action_scale * load_robot(ROBOT).friction.static)
    found = []
    for size in (0.0, 1e-7):
        agent = Noisy(policy.agent(load_robot(ROBOT), layout), size)
        ((flight,),) = run_rollouts(find_plant("nominal"), [policy], tasks, agents=[agent])
        found.append((flight.actions, score_circles(tasks[0], flight.recording)[0]))
    (actions, cell), (noisy, other) = found
    assert 0 < np.max(np.abs(noisy - actions) / np.abs(actions).max(axis=0)) < ACTION_TOLERANCE / 1000
    assert abs(other.rms_mm / cell.rms_mm - 1) < SCORE_TOLERANCE / 1000
    assert abs(other.max_mm / cell.max_mm - 1) < SCORE_TOLERANCE / 1000


def test_changed_weights_are_refused(honest):
    found = refusal(changed(honest, {"agent.py": agent_file("action = action * 1.1")}))
    assert found.check == "files"
    assert "weights were changed: agent.py" in found.reason


def test_an_agent_that_is_feed_forward_is_shown_no_errors():
    claim = replace(ABOUT, feedback=False)
    with pytest.raises(Refused, match="Unknown observation entry 'error'"):
        judge().pack(claim, PYTHON, agent_file('self.layout.read(observation, "error")'))
    manifest, _ = decode_submission(judge().pack(claim, PYTHON, agent_file()).data)
    assert not manifest.sees_errors


def test_older_manifests_do_not_say_the_track(honest):
    tree = manifest_of(honest)
    del tree["feedback"], tree["digest"]
    old = tree | {"digest": digest_of(tree)}
    for kind, sees in (("python", True), ("law", False)):
        source = AgentSource(kind=kind, law="elastic" if kind == "law" else None, file="agent.py" if sees else None)
        assert replace(decode_manifest(json.dumps(old).encode()), agent=source).sees_errors == sees


def test_changed_logged_actions_are_refused(honest):
    other = encode_arrays({"nominal_0": np.zeros((3, 6), dtype=np.float32)})
    assert "logged actions were changed" in refusal(changed(honest, {ACTIONS: other})).reason


def test_a_changed_manifest_is_refused(honest):
    found = refusal(changed(honest, manifest={"author": "somebody else"}, signed=False))
    assert (found.check, "was changed" in found.reason) == ("manifest", True)


@pytest.mark.parametrize(
    ("entry", "value", "reason"),
    [
        ("name", "two\nlines", "must be a line"),
        ("track", "oracle", "Unknown track 'oracle'"),
        ("preview", -1, "out of range"),
        ("agent", {"kind": "pickle", "law": None, "file": "agent.pkl"}, "Unknown kind of agent 'pickle'"),
        ("claims", [{"plant": "nominal"}], "not complete"),
        ("more", 1, "unknown entries more"),
        ("format", True, "has format True"),
        ("plants", {"draw:0": "0"}, "must be run on nominal"),
        ("claims", [], "claims 0 circles"),
    ],
)
def test_a_manifest_that_says_what_it_must_not_is_refused_though_its_digest_is_right(honest, entry, value, reason):
    assert reason in refusal(changed(honest, manifest={entry: value})).reason


@pytest.mark.parametrize("junk", [None, True, -1, 0.5, 1e300, "", "x" * 200, [], ["a"], [[]], {}, {"a": 1}])
def test_whatever_stands_in_a_manifest_is_taken_or_refused_and_nothing_breaks(honest, junk):
    tree = manifest_of(honest)
    changes = [{key: junk} for key in tree if key != "digest"]
    changes += [{"claims": [tree["claims"][0] | {key: junk}]} for key in tree["claims"][0]]
    changes += [{"agent": tree["agent"] | {key: junk}} for key in tree["agent"]]
    for change in changes:
        with contextlib.suppress(Refused):
            manifest, _ = decode_submission(changed(honest, manifest=change))
            check_physics(manifest, PLAN)


def test_other_physics_are_refused(honest):
    found = refusal(changed(honest, manifest={"plants": {"nominal": "0123456789abcdef"}}))
    assert found.check == "physics"
    assert "fingerprint" in found.reason
    assert "Pack it again" in found.reason


@pytest.mark.parametrize("entry", ["rms_mm", "max_mm"])
def test_better_errors_than_come_out_are_refused_though_the_digest_is_right(honest, entry):
    claims = deepcopy(manifest_of(honest)["claims"])
    claims[0][entry] *= 0.99
    found = refusal(changed(honest, manifest={"claims": claims}))
    assert (found.check, f"it claims {entry}" in found.reason) == ("replay", True)


@pytest.mark.parametrize("name", ["notes.txt", "../agent.py", "/agent.py", "a/b.py", "..", "a\\b.py", ".hidden", "a/"])
def test_a_file_that_nobody_needs_or_whose_name_leads_elsewhere_is_refused(honest, name):
    assert f"{name} is no file of a submission" in refusal(changed(honest, {name: b"hello"})).reason


def test_arrays_of_an_agent_that_would_unpack_to_too_much_are_refused(honest, monkeypatch):
    monkeypatch.setattr(manifests, "LARGEST", 30_000)
    large = io.BytesIO()
    np.savez_compressed(large, weights=np.zeros(30_000))
    files = {key: value for key, value in manifest_of(honest)["files"].items() if key == ACTIONS}
    files["agent.npz"] = hash_of(large.getvalue())
    agent = {"kind": "policy", "law": None, "file": "agent.npz"}
    data = changed(honest, {"agent.py": None, "agent.npz": large.getvalue()}, {"agent": agent, "files": files})
    found = refusal(data)
    assert (found.check, "agent.npz would unpack to" in found.reason) == ("archive", True)


def test_an_agent_that_is_too_large_is_refused_before_it_is_run(monkeypatch):
    monkeypatch.setattr(manifests, "LARGEST", 3000)
    monkeypatch.setattr(judging, "run_rollouts", None)
    with pytest.raises(Refused, match="would unpack to"):
        packed(content=agent_file() + b"#" * 3000)


def test_a_missing_file_is_refused(honest):
    assert "agent.py is missing" in refusal(changed(honest, {"agent.py": None})).reason


@pytest.mark.parametrize("bad", [np.full((500, 6), np.nan), np.full((500, 6), 2.0), np.zeros((500, 5))])
def test_logged_actions_that_no_agent_gives_are_refused(honest, bad):
    actions = encode_arrays({"nominal_0": bad.astype(np.float32)})
    files = manifest_of(honest)["files"] | {ACTIONS: hash_of(actions)}
    assert refusal(changed(honest, {ACTIONS: actions}, {"files": files})).check == "files"


def test_actions_of_another_agent_are_refused(honest):
    other = agent_file("action = action * 1.01")
    files = manifest_of(honest)["files"] | {"agent.py": hash_of(other)}
    found = refusal(changed(honest, {"agent.py": other}, {"files": files}))
    assert found.check == "agent"
    assert "does not decide what was logged" in found.reason


def test_an_agent_that_asks_for_another_environment_than_its_manifest_is_refused(honest):
    other = agent_file(head="PREVIEW = 2")
    files = manifest_of(honest)["files"] | {"agent.py": hash_of(other)}
    assert "asks for preview" in refusal(changed(honest, {"agent.py": other}, {"files": files})).reason


def test_an_agent_that_is_too_slow_is_refused(honest):
    other = agent_file("time.sleep(0.0045)")
    files = manifest_of(honest)["files"] | {"agent.py": hash_of(other)}
    found = refusal(changed(honest, {"agent.py": other}, {"files": files}))
    assert found.check == "time"
    assert re.search(r"takes \d{4,} us, must take at most 4000 us", found.reason)


def test_an_agent_that_lets_the_robot_stop_is_refused_when_it_is_packed():
    with pytest.raises(Refused, match="the robot stopped on nominal after"):
        packed(content=agent_file("action = action * 0 + (1 if count > 50 else 0)", head="ACTION_SCALE = 400.0"))


def test_agents_know_the_robot_that_the_controller_of_the_plant_knows():
    assert {controller_of(name) for name in PLAN} == {"irb4600_60_205"}
    known = load_robot(controller_of("workcell:thesis"))
    assert np.array_equal(known.friction.static, find_plant("workcell:thesis").rig.arm.robot.friction.static)


def test_actions_are_logged_as_they_act(honest):
    logged = decode_arrays(decode_archive(honest)[ACTIONS])["nominal_0"]
    assert logged.dtype == np.float32
    assert 0.0 < np.abs(logged).max() < 1.0


LOOKS_ASIDE = agent_file("action = action + 0.05 * action[:1]")
"""Its first row does not depend on others; its second does."""


def test_an_agent_that_acts_on_what_another_robot_sees_is_not_packed():
    with pytest.raises(Refused, match="nominal, motion 1 alone it does not decide what was logged"):
        packed(content=LOOKS_ASIDE, plan=SIDE_BY_SIDE)


def test_an_agent_that_acts_on_what_another_robot_sees_is_refused_though_it_was_packed():
    class Careless(Judge):
        def verify(self, data):
            return data

    careless = Careless(loaders=LOADERS, plan=SIDE_BY_SIDE, n_threads=1)
    assert refusal(careless.pack(ABOUT, PYTHON, LOOKS_ASIDE), plan=SIDE_BY_SIDE).check == "agent"


def test_an_agent_that_decides_otherwise_for_many_than_for_one_is_refused():
    honest = packed(plan=SIDE_BY_SIDE).data
    other = agent_file("action = action * (1.0 if len(observation) == 1 else 1.01)")
    files = manifest_of(honest)["files"] | {"agent.py": hash_of(other)}
    found = refusal(changed(honest, {"agent.py": other}, {"files": files}), plan=SIDE_BY_SIDE)
    assert (found.check, "motion 0 it does not decide what was logged" in found.reason) == ("agent", True)


def test_an_agent_that_keeps_its_memory_in_itself_is_packed_and_accepted():
    body = "self.past = 0.5 * getattr(self, 'past', 0 * action) + action\naction = 0.5 * self.past"
    data = packed(content=agent_file(body), plan=SIDE_BY_SIDE).data
    assert judge(SIDE_BY_SIDE).verify(data).action_difference == 0.0


@pytest.mark.parametrize(("times", "which"), [([4500.0] * 10, "median"), ([10.0] * 99 + [1e6], "mean")])
def test_decisions_that_take_longer_than_a_control_step_are_refused(times, which):
    with pytest.raises(Refused, match=f"must take at most 4000 us .{which} of"):
        check_time(times, 0.004)


def test_the_first_decision_may_take_long():
    check_time([1e6, *[10.0] * 99], 0.004)
