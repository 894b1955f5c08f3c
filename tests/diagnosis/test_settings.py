"""Settings of the diagnosis: each with its reason, and any of them can be varied."""

import ast
import inspect

import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis import settings as module
from ffgym.diagnosis.settings import record_reads, setting_values, settings, use_settings


def test_each_setting_says_its_meaning():
    """A string of at least some words follows each number."""
    for group in ast.parse(inspect.getsource(module)).body:
        if isinstance(group, ast.ClassDef) and group.name not in ("Settings", "_ReadGroup"):
            for number, text in zip(group.body[1::2], group.body[2::2], strict=True):
                assert isinstance(number, ast.AnnAssign)
                assert len(text.value.value.split()) > 3, number.target.id


def test_changed_settings_hold_inside_the_block_alone():
    """Others keep their values, and afterwards all is as before."""
    before = settings()
    with use_settings({"search.near_best": 0.25, "blocks.length": 2.0}):
        assert settings().search.near_best == 0.25
        assert settings().blocks.length == 2.0
        assert settings().search.tried == before.search.tried
    assert settings() is before


def test_blocks_of_changes_add_up():
    """An inner change keeps the outer one."""
    with use_settings({"search.tried": 1}), use_settings({"search.slack": 0.5}) as changed:
        assert setting_values()["search.tried"] == 1
        assert changed.search.slack == 0.5


def test_unknown_settings_are_told_with_those_there_are():
    """A slip of the pen changes nothing silently."""
    with pytest.raises(FFGymError, match=r"search\.neer.*search\.near_best"), use_settings({"search.neer": 0.1}):
        pass


def test_settings_that_are_read_are_recorded():
    """Values are those that hold, and nothing is recorded afterwards."""
    with use_settings({"search.tried": 7}), record_reads() as read:
        assert settings().search.tried == 7
    assert settings().search.slack > 0
    assert read == {"search.tried"}
