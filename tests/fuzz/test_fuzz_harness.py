"""The harness of mutations: it finds every fault that a reader can have, and each input can be made again."""

import json

import pytest

from ffgym.core.errors import FFGymError, check_choice
from ffgym.recordings import Phase
from scripts.fuzz.__main__ import Fuzz, main
from scripts.fuzz.groups import GROUPS, load_readers, share_inputs
from scripts.fuzz.outcome import FINDINGS, judge
from scripts.fuzz.reader import damage, make_valid
from scripts.fuzz.tally import Tally, load_tally, save_tally
from scripts.fuzz.watch import Watched
from tests.fuzz import bad_readers

SEED = 3


@pytest.mark.parametrize("name", [reader.name for reader in bad_readers.READERS])
def test_a_fault_of_a_reader_is_found_by_its_kind(name):
    with Watched(bad_readers.__name__, limit=0.5) as watched:
        outcome = watched.read(name, SEED, 0)
        assert outcome.kind == ("crash" if name == "exit" else name.split("_")[0])
        assert outcome.is_right == (name == "error")
        assert outcome.kind in FINDINGS or name == "error"
        assert watched.read("error", SEED, 1).kind == "error"  # in the same process, or in another one


def test_the_line_of_the_project_that_raised_is_named(tmp_path):
    def use(path):
        return Phase.from_dict({"label": path})

    found = judge(use, tmp_path)
    assert found.kind == "error"
    assert judge(lambda path: check_choice("name", {}, 3), tmp_path).place.startswith("ffgym/core/errors.py:")


@pytest.mark.parametrize("group", GROUPS)
def test_the_same_seed_and_number_give_the_same_damage(group, tmp_path):
    reader = load_readers((group,))[group][0]
    valid = make_valid(reader, tmp_path)
    found = [damage(reader, valid, SEED, number) for number in range(12)]
    assert found == [damage(reader, valid, SEED, number) for number in range(12)]
    contents = {one.data for one in found if isinstance(one.data, bytes)}
    assert len(contents) > 8
    assert damage(reader, valid, SEED + 1, 0) != found[0]


def test_a_run_that_was_interrupted_goes_on_with_the_next_input(tmp_path):
    options = {"readers": ("diagnosis",), "seed": SEED, "out": tmp_path / "fuzz"}
    Fuzz(inputs=20, **options).run()
    assert load_tally(tmp_path / "fuzz" / "fuzz.json", SEED).counts["diagnosis"].inputs == 20
    Fuzz(inputs=30, **options).run()
    tally = load_tally(tmp_path / "fuzz" / "fuzz.json", SEED)
    Fuzz(inputs=30, **(options | {"out": tmp_path / "whole"})).run()
    whole = load_tally(tmp_path / "whole" / "fuzz.json", SEED)
    for one, other in zip(tally.counts.values(), whole.counts.values(), strict=True):
        assert (one.inputs, one.errors, one.valid) == (other.inputs, other.errors, other.valid) != (30, 0, 0)
    with pytest.raises(FFGymError, match="is of seed 3, not of 4"):
        load_tally(tmp_path / "fuzz" / "fuzz.json", 4)


def test_one_input_is_read_again_and_kept(tmp_path, capsys):
    arguments = ["--readers", "results", "--seed", "3", "--only", "5", "--keep", str(tmp_path / "kept")]
    assert main(arguments) == 0
    assert sorted(file.name for file in (tmp_path / "kept").iterdir()) == ["mine.json", "none.json"]
    assert "of which" in capsys.readouterr().out
    assert main(arguments) == 1
    assert "exists already" in capsys.readouterr().err


def test_a_finding_ends_the_command_with_an_error_and_the_command_that_makes_it_again(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("scripts.fuzz.groups.GROUPS", (bad_readers.__name__,))
    monkeypatch.setattr("scripts.fuzz.__main__.load_readers", lambda: load_readers((bad_readers.__name__,)))
    arguments = [
        "--readers",
        "exception",
        "--inputs",
        "3",
        "--out",
        str(tmp_path / "o"),
        "--json",
        str(tmp_path / "j.json"),
    ]
    assert main(arguments) == 1
    said = capsys.readouterr()
    assert "KeyError: 'nothing'" in said.out
    assert "python -m scripts.fuzz --readers exception --seed 1 --only 0" in said.out
    assert "3 inputs ended neither in a result nor in one clear error" in said.err
    assert json.loads((tmp_path / "o" / "exception-0.json").read_text())["kind"] == "exception"
    document = json.loads((tmp_path / "j.json").read_text())
    assert document["total"] == {"inputs": 3, "errors": 0, "valid": 0, "findings": 3}
    assert document["versions"]["ffgym"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--readers", "none"], "Unknown reader 'none'"),
        (["--inputs", "0"], "--inputs = 0"),
        (["--only", "1"], "--only needs one reader"),
        (["--readers", "plan", "--keep", "x"], "--keep has no effect without --only"),
    ],
)
def test_a_slip_in_the_options_is_one_error(arguments, message, capsys):
    assert main(arguments) == 1
    assert message in capsys.readouterr().err


def test_inputs_are_shared_so_that_fast_readers_get_more():
    readers = [reader for group in load_readers().values() for reader in group]
    shares = share_inputs(readers, 5000)
    assert 4900 <= sum(shares.values()) <= 5100
    assert shares["recording_csv"] > 4 * shares["recording_checked"] > 0


def test_counts_that_are_no_json_are_refused(tmp_path):
    save_tally(tmp_path / "fuzz.json", Tally(seed=1))
    assert load_tally(tmp_path / "fuzz.json", 1) == Tally(seed=1)
    (tmp_path / "fuzz.json").write_text("[" * 100_000, encoding="utf-8")
    with pytest.raises(FFGymError, match="is not valid JSON"):
        load_tally(tmp_path / "fuzz.json", 1)
