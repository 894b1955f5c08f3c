"""Files of learned laws: whole, or one clear error."""

import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

from ffgym.agents.law_files import StoredLaw, load_law, pack, save_law, unpack
from ffgym.control import CausalLaw
from ffgym.core.errors import FFGymError, check_shape


@dataclass(frozen=True, eq=False)
class Viscous(CausalLaw, StoredLaw):
    """The smallest law with something to store."""

    coefficient: np.ndarray
    name: str = "viscous"
    kind: ClassVar[str] = "viscous"

    @property
    def n_joints(self):
        return len(self.coefficient)

    def step(self, memory, window):
        return self.coefficient * window.motor_dq[..., 1, :], memory

    def parts(self):
        return {"name": self.name}, {"coefficient": self.coefficient}

    @classmethod
    def from_parts(cls, settings: Mapping[str, Any], arrays):
        return cls(check_shape("coefficient", arrays["coefficient"], (None,)), name=settings["name"])


@pytest.fixture
def stored(tmp_path):
    law = Viscous(np.array([1 / 3, np.pi]))
    return law, save_law(tmp_path / "law.npz", law, {"trials": 3})


def test_a_law_comes_back_bit_for_bit_with_what_was_noted(stored):
    law, path = stored
    again = load_law(path)
    assert (type(again), again.name) == (Viscous, "viscous")
    np.testing.assert_array_equal(again.coefficient, law.coefficient)
    header, _ = unpack(path)
    assert header["meta"] == {"trials": 3}
    assert {"ffgym", "numpy"} <= header["versions"].keys()


def test_equal_laws_give_equal_bytes(stored, tmp_path):
    law, path = stored
    assert save_law(tmp_path / "again.npz", law, {"trials": 3}).read_bytes() == path.read_bytes()


def changed(path, **header):
    old, arrays = unpack(path)
    path.write_bytes(pack(old | header, arrays))


def test_what_is_no_law_is_one_clear_error(stored, tmp_path):
    _, path = stored
    with pytest.raises(FFGymError, match=r"must end in \.npz"):
        save_law(tmp_path / "law.bin", stored[0])
    with pytest.raises(FFGymError, match="does not exist"):
        save_law(tmp_path / "absent" / "law.npz", stored[0])
    with pytest.raises(FFGymError, match="no such file"):
        load_law(tmp_path / "absent.npz")
    changed(path, kind="dance")
    with pytest.raises(FFGymError, match=r"Unknown kind of law .* 'dance'. Available: .*viscous"):
        load_law(path)
    changed(path, kind="viscous", settings={})
    with pytest.raises(FFGymError, match="no complete law of kind 'viscous'"):
        load_law(path)
    changed(path, format=99)
    with pytest.raises(FFGymError, match="has format 99, this version of ffgym reads 1"):
        load_law(path)


@pytest.mark.parametrize(
    ("coefficient", "name", "reason"),
    [([1.0, np.nan], "viscous", "must be finite"), ([[1.0]], "viscous", "has shape"), ([1.0], None, "must be text")],
)
def test_numbers_and_names_that_make_no_law_are_refused_with_the_file_they_stand_in(stored, coefficient, name, reason):
    _, path = stored
    header, _ = unpack(path)
    path.write_bytes(pack(header | {"settings": {"name": name}}, {"coefficient": np.array(coefficient)}))
    with pytest.raises(FFGymError, match=rf"law\.npz: holds no complete law of kind 'viscous': .*{reason}"):
        load_law(path)


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: b"",
        lambda data: data[: len(data) // 2],
        lambda data: b"PK\x03\x04" + b"x" * 100,
        lambda data: bytes([*data[:60], data[60] ^ 0xFF, *data[61:]]),
        lambda data: b"hello",
    ],
)
def test_a_damaged_file_is_one_clear_error(stored, damage):
    _, path = stored
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(FFGymError, match=r"is damaged or no file of ffgym|is empty"):
        load_law(path)


def test_any_flipped_byte_is_the_same_law_or_one_clear_error(stored):
    law, path = stored
    data = path.read_bytes()
    for k in range(0, len(data), 7):
        path.write_bytes(bytes([*data[:k], data[k] ^ 0x55, *data[k + 1 :]]))
        with suppress(FFGymError):
            np.testing.assert_array_equal(load_law(path).coefficient, law.coefficient)


def test_a_header_that_is_no_table_and_pickles_are_refused(tmp_path):
    path = tmp_path / "law.npz"
    np.savez(path, header=np.array(json.dumps([1, 2])))
    with pytest.raises(FFGymError, match=r"has format \[1, 2\]"):
        load_law(path)
    np.savez(path, header=np.array([{"format": 1}], dtype=object))
    with pytest.raises(FFGymError, match="is damaged"):
        load_law(path)
