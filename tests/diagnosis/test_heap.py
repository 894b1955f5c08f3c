"""Freed memory is given back where the C library can do that, and nothing happens elsewhere."""

import ctypes

import pytest

from ffgym.diagnosis import computing


def test_the_c_library_is_asked_to_keep_nothing(monkeypatch):
    asked = []

    class Library:
        @staticmethod
        def malloc_trim(kept):
            asked.append(kept)

    monkeypatch.setattr(ctypes, "CDLL", lambda name: Library)
    computing.trim_heap()
    assert asked == [0]


@pytest.mark.parametrize("error", [OSError, TypeError, None])
def test_a_system_whose_library_cannot_goes_on(monkeypatch, error):
    def library(name):
        if error is not None:
            raise error
        return object()

    monkeypatch.setattr(ctypes, "CDLL", library)
    computing.trim_heap()
