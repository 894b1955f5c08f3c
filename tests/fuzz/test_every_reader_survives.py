"""5,000 damaged files, shared among all readers: each gives a result or one clear error."""

import pytest

from scripts.fuzz.groups import GROUPS, load_readers, share_inputs
from scripts.fuzz.tally import Tally
from scripts.fuzz.watch import Watched

INPUTS, SEED = 5000, 1


@pytest.mark.parametrize("group", GROUPS)
def test_damaged_files_give_a_result_or_one_clear_error(group):
    shares = share_inputs([reader for readers in load_readers().values() for reader in readers], INPUTS)
    tally = Tally(seed=SEED)
    with Watched(group) as watched:
        for reader in load_readers((group,))[group]:
            for number in range(shares[reader.name]):
                tally.add(reader.name, number, watched.read(reader.name, SEED, number))
    assert tally.findings == []
    for name, count in tally.counts.items():
        assert count.errors > 0, name
        assert count.valid + count.errors == shares[name]
