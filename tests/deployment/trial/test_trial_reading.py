"""Reading of trials: the gain comes out, and what an operator, a logger or a machine got wrong is named."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.deployment.trial import read_trial
from ffgym.deployment.trial.gains import OVERALL
from ffgym.deployment.trial.matching import TrialLog
from ffgym.deployment.trial.words import format_trial, say_gain
from tests.deployment.trial.trial_samples import Machine, make_plan, make_program

SLOW, FAST = make_program("slow"), make_program("fast", speed=1.5)
PLAN = make_plan(SLOW, FAST, pairs=2)
LOGS = Machine().carry_out(PLAN)
ONE = make_plan(pairs=6, warm_up=0, seed=2)


@pytest.fixture(scope="module")
def whole():
    """Gains of all logs under their own names."""
    return read_trial(PLAN, LOGS).gains


def why(result, number: int) -> str:
    """Reason why a run does not count."""
    return result.runs[number - 1].left_out


def test_the_gain_of_each_program_and_over_all_is_that_of_the_machine():
    plan = make_plan(SLOW, FAST, pairs=7)
    result = read_trial(plan, Machine().carry_out(plan))
    assert result.measure == "tool"
    assert [gain.name for gain in result.gains] == ["slow", "fast", OVERALL]
    for gain in result.gains:
        assert gain.low < 0.4 < gain.high
        assert gain.high - gain.low < 0.05
        assert gain.claim == "gain"
    assert [one.log for one in result.runs] == [run.log for run in plan.runs]
    assert not result.notes
    assert "28 of 28 runs count" in format_trial(result)


def test_a_correction_without_effect_gains_nothing_and_one_that_harms_is_worse():
    (nothing,) = read_trial(ONE, Machine(corrected=1e-4).carry_out(ONE)).gains
    assert say_gain(nothing).startswith("no gain shown: -")
    (harm,) = read_trial(ONE, Machine(corrected=1.3e-4).carry_out(ONE)).gains
    assert say_gain(harm).startswith("worse by ")


def test_logs_are_matched_by_name_in_any_order_and_strangers_are_named(whole):
    stranger = TrialLog("notes_of_monday", LOGS[0].recording)
    shuffled = [*LOGS[::-1], stranger]
    result = read_trial(PLAN, shuffled)
    assert result.gains == whole
    assert any("notes_of_monday" in note for note in result.notes)


def test_the_number_that_a_log_begins_with_is_enough(whole):
    short = [replace_name(log, log.name[:1] + " take") for log in LOGS]
    assert read_trial(PLAN, short).gains == whole


def test_logs_without_names_of_the_plan_are_matched_by_their_clocks(whole):
    anonymous = [replace_name(log, f"trace {chr(97 + k)}") for k, log in enumerate(LOGS)]
    result = read_trial(PLAN, [*anonymous[5:], *anonymous[:5]])
    assert result.gains == whole
    assert any("order of their clocks" in note for note in result.notes)
    with pytest.raises(FFGymError, match="No log has a name of the plan"):
        read_trial(PLAN, anonymous[:-2])


def test_a_missing_log_takes_its_pair_along_and_both_are_told():
    kept = [log for log in LOGS if log.name != PLAN.runs[4].log]
    result = read_trial(PLAN, kept)
    pair = [run.number for run in PLAN.runs if (run.program, run.pair) == (PLAN.runs[4].program, PLAN.runs[4].pair)]
    (other,) = set(pair) - {5}
    assert why(result, 5) == "its log is missing"
    assert why(result, other) == "the other run of its pair, 5, does not count"
    assert sum(one.counts for one in result.runs) == 6
    assert any("Run 5" in note for note in result.notes)


def test_a_missing_warm_up_run_costs_nothing(whole):
    result = read_trial(PLAN, LOGS[1:])
    assert result.gains == whole


@pytest.mark.parametrize("number", [2, 3])
def test_a_run_whose_correction_was_not_switched_as_planned_is_named_by_its_command(number):
    logs = Machine().carry_out(ONE, switch=lambda run, on: on != (run == number))
    result = read_trial(ONE, logs)
    shown = "without the correction" if ONE.runs[number - 1].corrected else "with the correction"
    assert f"reference.position is that of a run {shown}" in why(result, number)
    assert sum(one.counts for one in result.runs) == 10
    assert result.gains[0].low < 0.4 < result.gains[0].high


def test_an_operator_who_mixed_up_two_logs_of_a_pair_is_told_so():
    logs = Machine().carry_out(ONE)
    names = [log.name for log in logs]
    names[2], names[3] = names[3], names[2]
    result = read_trial(ONE, [replace_name(log, name) for log, name in zip(logs, names, strict=True)])
    assert "swapped, or its log mislabelled" in why(result, 3)
    assert "swapped, or its log mislabelled" in why(result, 4)
    assert result.gains[0].pairs == 5
    assert any("the order was not that of the plan" in note and "3" in note for note in result.notes)


def test_a_correction_that_was_on_whenever_it_should_be_off_is_noticed_in_all_runs():
    with pytest.raises(FFGymError, match=r"No pair of runs is left.*is that of a run with the correction"):
        read_trial(ONE, Machine().carry_out(ONE, switch=lambda run, on: not on))


def test_runs_without_a_correction_in_their_commands_are_read_with_a_warning():
    result = read_trial(ONE, Machine(commands=False).carry_out(ONE))
    assert result.gains[0].claim == "gain"
    assert any("no command in the logs differs" in note for note in result.notes)
    never = read_trial(ONE, Machine(corrected=1e-4).carry_out(ONE, switch=lambda run, on: False))
    assert never.gains[0].claim == "none"
    assert any("no command in the logs differs" in note for note in never.notes)


def test_a_log_of_another_program_or_at_another_speed_is_named():
    slow = next(run for run in PLAN.runs if run.program == "slow" and not run.is_warm_up)
    rng = np.random.default_rng(0)
    other = Machine().run(FAST, slow.corrected, rng=rng)
    result = read_trial(PLAN, [replace_log(log, other) if log.name == slow.log else log for log in LOGS])
    assert why(result, slow.number) == "its log shows program fast, not slow"
    override = Machine().run(make_program("slow", speed=1.1), slow.corrected, rng=rng)
    result = read_trial(PLAN, [replace_log(log, override) if log.name == slow.log else log for log in LOGS])
    assert why(result, slow.number) == "it ran at 110% of the speed of slow"


def test_a_name_that_says_the_other_kind_is_not_believed_against_the_plan():
    number = next(run.number for run in ONE.runs if run.corrected)
    logs = [
        replace_name(log, f"{number:02d}_line_off") if log.name == ONE.runs[number - 1].log else log
        for log in Machine().carry_out(ONE)
    ]
    assert "is named 'off'" in why(read_trial(ONE, logs), number)


def test_several_logs_of_one_run_are_told_unless_one_has_its_very_name():
    logs = Machine().carry_out(ONE)
    again = replace_name(logs[3], logs[3].name + "_again")
    assert read_trial(ONE, [*logs, again]).gains == read_trial(ONE, logs).gains
    renamed = [replace_name(log, log.name + "_first") if log is logs[3] else log for log in logs]
    assert "several logs" in why(read_trial(ONE, [*renamed, again]), 4)


def test_the_first_of_several_laps_is_not_scored():
    plan = make_plan(laps=3, pairs=2)
    cold, warm = Machine(without=5e-4, corrected=5e-4, scatter=0), Machine(scatter=0)
    rng, logs = np.random.default_rng(0), []
    for run in plan.runs:
        first, rest = (m.run(plan.programs[0], run.corrected, rng=rng, laps=3) for m in (cold, warm))
        early = rest.t < 0.5 + plan.programs[0].duration
        columns = {name: np.where(early, first[name], rest[name]) for name in rest.columns}
        logs.append(TrialLog(run.log, rest.derive(columns)))
    result = read_trial(plan, logs)
    assert result.gains[0].without == pytest.approx(100, rel=0.03)
    assert result.gains[0].gain == pytest.approx(0.4, abs=0.03)
    short = [TrialLog(log.name, log.recording.slice(end=0.6 + plan.programs[0].duration)) for log in logs[:3]]
    assert "one lap of 3" in why(read_trial(plan, [*short, *logs[3:]]), 2)


def test_without_a_tracker_motors_are_judged_and_it_is_said_what_they_do_not_see():
    result = read_trial(ONE, Machine(noise=0.0).carry_out(ONE))
    assert (result.measure, result.unit.name) == ("motors", "mrad")
    assert result.gains[0].gain == pytest.approx(0.4, abs=0.02)
    assert any("springs" in note for note in result.notes)


def test_a_run_that_the_tracker_did_not_see_is_left_out():
    logs, blind = Machine().carry_out(ONE), Machine(noise=0.0).carry_out(ONE)
    result = read_trial(ONE, [*logs[:5], blind[5], *logs[6:]])
    assert why(result, 6) == "no tracker saw its tool"
    assert result.gains[0].pairs == 5


def test_motors_are_judged_where_the_tracker_saw_the_tool_in_few_runs():
    logs, blind = Machine().carry_out(ONE), Machine(noise=0.0).carry_out(ONE)
    result = read_trial(ONE, [*logs[:3], *blind[3:]])
    assert result.measure == "motors"
    assert result.gains[0].pairs == 6


def test_runs_can_be_left_out_on_request_and_unknown_ones_are_refused():
    result = read_trial(PLAN, LOGS, without=[7])
    assert why(result, 7) == "it was left out on request"
    assert sum(one.counts for one in result.runs) == 6
    with pytest.raises(FFGymError, match="Run 99 to leave out is not in the plan"):
        read_trial(PLAN, LOGS, without=[99])


def test_a_log_that_is_no_use_is_left_out_with_the_reason_of_the_quality_gate():
    logs = Machine().carry_out(ONE)
    bad = logs[4].recording
    twice = {name: values.copy() for name, values in bad.columns.items() if name != "timestamp"}
    for values in twice.values():
        values[200:260] = values[140:200]  # a second that was copied into the next one
    copied = bad.derive({"timestamp": bad.t, **twice})
    result = read_trial(ONE, [*logs[:4], TrialLog(logs[4].name, copied), *logs[5:]])
    assert why(result, 5).startswith("its log is insufficient: ")
    assert not why(result, 5).endswith(".")
    assert result.gains[0].pairs == 5


def test_errors_that_the_noise_of_the_tracker_hides_are_told():
    result = read_trial(ONE, Machine(corrected=1e-7, noise=3e-5).carry_out(ONE))
    assert any("Noise of the sensor" in note for note in result.notes)


def test_why_nothing_is_claimed_though_the_interval_leaves_out_zero_is_said():
    plan = make_plan(pairs=4)
    text = format_trial(read_trial(plan, Machine().carry_out(plan)))
    assert "no gain shown: 3" in text
    assert "4 pairs can be ordered in too few ways" in text


def test_a_program_that_the_whole_is_without_is_named(whole):
    lost = next(run.number for run in PLAN.runs if run.program == "slow" and not run.is_warm_up)
    text = " ".join(format_trial(read_trial(PLAN, LOGS, without=[lost])).split())
    assert "all programs: without slow, of which fewer than two pairs are left." in text
    assert "without slow" not in " ".join(format_trial(read_trial(PLAN, LOGS)).split())


def replace_name(log: TrialLog, name: str) -> TrialLog:
    """The same recording under another name."""
    return TrialLog(name, log.recording)


def replace_log(log: TrialLog, recording) -> TrialLog:
    """Another recording under the same name."""
    return TrialLog(log.name, replace_clock(recording, log.recording.t[0]))


def replace_clock(recording, begin: float):
    """The same recording on another clock."""
    columns = {**recording.columns, "timestamp": recording.t - recording.t[0] + begin}
    return recording.derive(columns, replace(recording.header, phases=()))
