"""Processes of commands that write, one for all tests of this folder."""

import pytest

from tests.contract.killing import process_of_commands


@pytest.fixture(scope="session")
def few(tmp_path_factory):
    """The process of the commands of the usual tests."""
    with process_of_commands(tmp_path_factory.mktemp("few"), "tests.contract.writing_commands:make_stock") as made:
        yield made


@pytest.fixture(scope="session")
def every(tmp_path_factory):
    """The process of all commands."""
    setting = "tests.contract.writing_commands:make_whole_stock"
    with process_of_commands(tmp_path_factory.mktemp("every"), setting) as made:
        yield made
