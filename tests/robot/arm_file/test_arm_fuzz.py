"""Whatever is in a file, reading it gives an arm or one FFGymError, and nothing else ever happens."""

import re

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from ffgym.core.errors import FFGymError
from ffgym.robot.arm_file import ArmFile, read_arm
from tests.robot.arm_file.arm_file_samples import ARMS, FILES

TEXTS = {name: (FILES / name).read_text(encoding="utf-8") for name in ARMS}
JUNK = ["", "nan", "inf", "-1", "0", "1e400", "1e-400", "x", "0 0", "true", "é", "../..", "free", "1 2 3 4 5 6 7"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("fuzz")


def arm_or_refusal(folder, name, data):
    """Read; anything but an arm of finite numbers or an FFGymError of one line is a failure."""
    path = folder / name
    path.write_bytes(data)
    try:
        arm = read_arm(path, looks=False)
    except FFGymError as error:
        assert str(error).startswith(f"{path}: ")  # noqa: PT017
        assert "\n" not in str(error)  # noqa: PT017
    else:
        assert isinstance(arm, ArmFile)
        assert all(np.all(np.isfinite(quantity.value)) for quantity in arm.quantities.values())
    assert not (folder / "MUJOCO_LOG.TXT").exists()


names = st.sampled_from(sorted(TEXTS))


@settings(max_examples=60)
@given(name=names, data=st.data())
def test_a_file_that_is_cut_off(folder, name, data):
    text = TEXTS[name].encode()
    arm_or_refusal(folder, name, text[: data.draw(st.integers(0, len(text)))])


@settings(max_examples=60)
@given(name=names, data=st.data())
def test_a_file_without_some_of_its_lines(folder, name, data):
    lines = TEXTS[name].splitlines()
    first, count = data.draw(st.integers(0, len(lines) - 1)), data.draw(st.integers(1, 6))
    arm_or_refusal(folder, name, "\n".join(lines[:first] + lines[first + count :]).encode())


@settings(max_examples=150)
@given(name=names, data=st.data())
def test_a_file_with_any_value_of_any_attribute_replaced(folder, name, data):
    values = [match.span(1) for match in re.finditer(r'="([^"]*)"', TEXTS[name])]
    start, end = data.draw(st.sampled_from(values))
    text = TEXTS[name][:start] + data.draw(st.sampled_from(JUNK)) + TEXTS[name][end:]
    arm_or_refusal(folder, name, text.encode())


def test_an_infinite_gear_is_refused(folder):
    text = TEXTS["kr_like.xml"].replace('gear="120"', 'gear="inf"', 1)
    assert "inf" in text
    (folder / "kr_like.xml").write_text(text)
    with pytest.raises(FFGymError, match=r"gear of an actuator of joint 'joint_a\d' is \[inf\], must be finite"):
        read_arm(folder / "kr_like.xml", looks=False)


@settings(max_examples=60)
@given(name=names, data=st.data())
def test_a_file_with_bytes_overwritten(folder, name, data):
    text = TEXTS[name].encode()
    start = data.draw(st.integers(0, len(text)))
    junk = data.draw(st.binary(min_size=1, max_size=8))
    arm_or_refusal(folder, name, text[:start] + junk + text[start + len(junk) :])


@settings(max_examples=60)
@given(st.binary(max_size=80))
@example(b"<mujoco>" + b"<default>" * 3000)
@example(b"<robot>" + b"<link>" * 3000)
@example(b"<robot name='r'/>")
@example(b"<mujoco/>")
def test_any_bytes(folder, data):
    arm_or_refusal(folder, "arm.xml", data)
