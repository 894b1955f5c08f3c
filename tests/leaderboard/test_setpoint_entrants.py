"""Agents act through set-points on the leaderboard as laws do in a simulation."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from ffgym.agents import dynamic_lugre, elastic_feedforward
from ffgym.agents.entrants import ENTRANTS, make_submitted
from ffgym.agents.law_agent import LawPolicy
from ffgym.control import SetpointChannel, SetpointResponse, find_channel
from ffgym.core.errors import FFGymError
from ffgym.leaderboard.comparison.standings import standings
from ffgym.leaderboard.entrants import ReadyAgent
from ffgym.leaderboard.evaluation.closed_loop import inference_time, run_references, run_rollouts
from ffgym.leaderboard.evaluation.jobs import SeededAgent, run_agents, score_circles
from ffgym.leaderboard.plants import find_plant
from ffgym.leaderboard.results import SentSetpoints, decode_row, encode_row
from ffgym.leaderboard.submission.manifest import AgentSource, decode_manifest
from ffgym.leaderboard.tasks import Task, make_references
from ffgym.simulation import Run, simulate
from tests.leaderboard.submission_samples import ABOUT, PLAN, judge, manifest_of
from tests.leaderboard.synthetic_rows import plants, row

RESULTS = Path(__file__).parents[2] / "docs" / "leaderboard" / "results"
FAST = Task("p2", 0.1, (0.001,), "positions")
LATE = SetpointResponse(delay=0.008)
CHANNELS = {
    "torque": None,
    "set-points": SetpointChannel(),
    "late": SetpointChannel(response=LATE, known=SetpointResponse()),
    "compensated": SetpointChannel(response=LATE),
}


@pytest.fixture(scope="module")
def plant():
    return find_plant("draw:4")


@pytest.fixture(scope="module")
def law(plant):
    return elastic_feedforward(plant.rig.robot)


@pytest.fixture(scope="module")
def simulated(plant, law):
    """Errors of the law on one circle through each channel, as `simulate` gives them."""
    [reference] = make_references(plant.rig.arm, [FAST])
    runs = [Run(reference=reference, law=law, channel=channel) for channel in CHANNELS.values()]
    found = simulate(runs, machine=plant.machine)
    return {name: score_circles(FAST, recording) for name, recording in zip(CHANNELS, found, strict=True)}


def test_a_law_scores_through_each_channel_as_in_a_simulation(plant, law, simulated):
    seeded = [
        SeededAgent(name=name, seed=0, ready=ReadyAgent(law=law, channel=channel)) for name, channel in CHANNELS.items()
    ]
    assert {name: list(outcome.cells) for name, outcome in run_agents(plant, seeded, [FAST])} == simulated
    rms = {name: cells[0].rms_mm for name, cells in simulated.items()}
    assert rms["set-points"] == pytest.approx(rms["torque"], rel=0.2)
    assert rms["compensated"] == pytest.approx(rms["set-points"], rel=0.02)
    assert rms["late"] > 1.5 * rms["torque"]


def test_a_law_scores_through_set_points_the_same_as_a_policy_in_the_environment(plant, law, simulated):
    policy = LawPolicy(make=lambda robot: law, preview=law.preview, channel="setpoint")
    [[flight]] = run_rollouts(plant, [policy], [FAST])
    [flown], [run] = score_circles(FAST, flight.recording), simulated["set-points"]
    assert flown.rms_mm == pytest.approx(run.rms_mm, rel=1e-6)
    assert flown.rms_mm != pytest.approx(simulated["torque"][0].rms_mm, rel=1e-4)
    # along any motion, too
    [along] = run_references(plant.rig, policy, make_references(plant.rig.arm, [FAST]))
    assert score_circles(FAST, along)[0].rms_mm == pytest.approx(run.rms_mm, rel=1e-6)


def test_policies_of_two_channels_do_not_run_side_by_side(plant, law):
    policies = [LawPolicy(make=lambda robot: law, preview=4, channel=channel) for channel in ("torque", "setpoint")]
    with pytest.raises(FFGymError, match="one preview, action scale, track and channel"):
        run_rollouts(plant, policies, [FAST])


@pytest.mark.parametrize("run", [run_rollouts, inference_time])
def test_a_channel_that_is_unknown_is_refused_by_name(plant, law, run):
    policy = LawPolicy(make=lambda robot: law, preview=4, channel="current")
    with pytest.raises(FFGymError, match=r"Unknown channel of a policy 'current'. Available: setpoint, torque."):
        run(plant, policy) if run is inference_time else run(plant, [policy], [FAST])


def test_an_agent_declares_a_channel_and_no_name_of_one(law):
    with pytest.raises(FFGymError, match=r"channel of agent 'elastic' must be a SetpointChannel\(\), or None"):
        replace(ENTRANTS["elastic"], channel="setpoint")
    policy = LawPolicy(make=lambda robot: law, preview=4)
    with pytest.raises(FFGymError, match="A policy acts through its own attribute channel"):
        ReadyAgent(policy=policy, channel=SetpointChannel())


def through(name, channel):
    """A row of an agent that acts through a channel."""
    return replace(row(name, ["nominal"]), setpoints=None if channel is None else SentSetpoints.through(channel))


@pytest.mark.parametrize("channel", CHANNELS.values(), ids=CHANNELS)
def test_a_result_file_tells_what_the_row_acts_through(channel):
    written = through("elastic", channel)
    text = encode_row(written)
    read = decode_row(text, "elastic.json")
    assert read.setpoints == written.setpoints
    assert read.channel == ("torque" if channel is None else "setpoint")
    assert ("setpoints" in json.loads(text)) == (channel is not None)


@pytest.mark.parametrize("name", ["elastic", "servo_gains"])
def test_files_from_before_set_points_are_written_as_they_were(name):
    text = (RESULTS / f"{name}.json").read_text(encoding="utf-8")
    assert encode_row(decode_row(text, name)) == text


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("setpoint", "must be an object"),
        ({"response": {"delay": 0.008, "lag": 0.0, "curvature": 0.0}}, "lacks known"),
        (
            {name: {"delay": -0.1, "lag": 0.0, "curvature": 0.0} for name in ("response", "known")},
            "delay of set-points",
        ),
    ],
    ids=["a name", "half", "before it is sent"],
)
def test_a_result_file_with_set_points_that_cannot_be_is_refused(entry, message):
    tree = json.loads(encode_row(through("elastic", SetpointChannel()))) | {"setpoints": entry}
    with pytest.raises(FFGymError, match=rf"mine.json: is no result of the leaderboard: .*{message}"):
        decode_row(json.dumps(tree), "mine.json")


def test_what_is_sent_is_described_with_what_is_compensated():
    said = {name: SentSetpoints.through(channel) for name, channel in CHANNELS.items() if channel is not None}
    assert {name: each.describe() for name, each in said.items()} == {
        "set-points": "delay 0.00 ms, no filter",
        "late": "delay 8.00 ms, no filter, not compensated",
        "compensated": "delay 8.00 ms, no filter, compensated",
    }
    assert {name: each.lateness_ms for name, each in said.items()} == {"set-points": 0, "late": 8, "compensated": 0}
    half = SetpointChannel(response=LATE, known=SetpointResponse(delay=0.004))
    assert SentSetpoints.through(half).describe().endswith("compensated as delay 4.00 ms, no filter")


def test_ranks_within_a_track_leave_other_channels_out():
    every = plants(0)
    other = replace(row("lugre_static", every), setpoints=SentSetpoints())
    rows = [row("none", every), row("elastic", every), row("lugre_dynamic", every), other]
    lines = {line.row.name: line for line in standings(rows, "nominal", "held_out").lines}
    found = {name: (line.rank, line.track_rank) for name, line in lines.items()}
    assert found == {"elastic": (1, 1), "lugre_dynamic": (2, 2), "lugre_static": (3, 1), "none": (None, None)}


@pytest.fixture(scope="module")
def submitted():
    """Submission of a law through set-points."""
    return judge().pack(replace(ABOUT, channel="setpoint"), AgentSource(kind="law", law="lugre_dynamic"), None)


def test_a_submission_through_set_points_scores_as_in_a_simulation(submitted):
    assert submitted.manifest.channel == manifest_of(submitted.data)["channel"] == "setpoint"
    rig, [task] = find_plant("nominal").rig, PLAN["nominal"]
    [reference] = make_references(rig.arm, [task])
    run = Run(reference=reference, law=dynamic_lugre(rig.robot), channel=SetpointChannel())
    [cell] = score_circles(task, simulate([run])[0])
    assert [claim.rms_mm for claim in submitted.claims] == [pytest.approx(cell.rms_mm, rel=1e-4)]


def test_a_submission_through_set_points_has_a_row_that_tells_it(submitted, tmp_path):
    (tmp_path / "mine.zip").write_bytes(submitted.data)
    entrant = make_submitted(tmp_path / "mine.zip")
    assert entrant.row().channel == "setpoint"
    [ready] = entrant.ready(find_plant("nominal"), [0], ())
    assert find_channel(ready.policy) == "setpoint"


def test_manifests_of_torques_are_written_as_before_set_points(submitted):
    tree = replace(submitted.manifest, channel="torque").tree()
    assert "channel" not in tree
    assert decode_manifest(json.dumps(tree).encode()).channel == "torque"


def test_a_residual_policy_is_not_submitted_through_set_points():
    source = AgentSource(kind="policy", file="agent.npz")
    with pytest.raises(FFGymError, match="A residual policy adds torque, and cannot act through set-points"):
        judge().pack(replace(ABOUT, channel="setpoint"), source, b"")
    with pytest.raises(FFGymError, match="Unknown channel 'current'"):
        replace(ABOUT, channel="current")
