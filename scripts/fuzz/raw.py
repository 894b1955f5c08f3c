"""Mutation of bytes and of text, whatever they mean."""

import re

import numpy as np

from scripts.fuzz.values import FACTORS, NUMBERS, TEXTS

_NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?!\w)")
_WORD = re.compile(r"[A-Za-z_][\w.]*")
_SIGNS = "()[]{}<>\"'`,;:=#!/\\|%&$~^*+-.\t\r\n\0\x1a\ufeff\u2028é"
_BYTES = (0, 1, 9, 10, 13, 32, 34, 127, 128, 254, 255)


def mutate_bytes(data: bytes, rng: np.random.Generator) -> bytes:
    """Flip, cut, drop, repeat, overwrite or insert bytes, in one place or in some."""
    size = len(data)
    if not size:
        return bytes(rng.integers(0, 256, size=8, dtype=np.uint8))
    first = int(rng.integers(size))
    end = min(size, first + int(2 ** rng.uniform(0, 10)))
    kind = rng.integers(8)
    if kind == 0:
        return data[:first]
    if kind == 1:
        return data[:first] + data[end:]
    if kind == 2:
        return data[:end] + data[first:end] * int(rng.integers(1, 20)) + data[end:]
    if kind == 3:
        other = int(rng.integers(size))
        return data[:first] + data[other : other + end - first] + data[end:]
    if kind == 4:
        noise = rng.integers(0, 256, size=end - first, dtype=np.uint8).tobytes()
        return data[:first] + noise + data[end if rng.random() < 0.5 else first :]
    changed = bytearray(data)
    for place in rng.integers(0, size, size=int(rng.integers(1, 6))):
        if kind == 5:
            changed[place] ^= 1 << int(rng.integers(8))
        else:
            changed[place] = int(rng.choice(_BYTES)) if kind == 6 else int(rng.integers(256))
    return bytes(changed)


def mutate_text(text: str, rng: np.random.Generator) -> str:
    """Change a line, a number, a word or a sign of a text."""
    kind = rng.integers(9)
    if kind <= 1:
        return _mutate_lines(text, rng)
    if kind <= 4:
        return _mutate_number(text, rng)
    if kind == 5:
        return _mutate_word(text, rng)
    place = int(rng.integers(len(text) + 1))
    sign = _SIGNS[rng.integers(len(_SIGNS))]
    if kind == 6:
        return text[:place] + text[place + 1 :]
    if kind == 7:
        return text[:place] + sign * int(rng.choice([1, 1, 1, 2, 3, 400, 30_000])) + text[place:]
    return text.replace("\n", str(rng.choice(["\r\n", "\r", " ", "\n\n"]))) if rng.random() < 0.2 else text[:place]


def _mutate_lines(text: str, rng: np.random.Generator) -> str:
    lines = text.split("\n")
    k, other = (int(rng.integers(len(lines))) for _ in range(2))
    kind = rng.integers(4)
    if kind == 0:
        del lines[k]
    elif kind == 1:
        lines[k], lines[other] = lines[other], lines[k]
    elif kind == 2:
        lines[k:k] = [lines[k]] * int(rng.choice([1, 1, 2, 1000]))
    else:
        lines[k] = TEXTS[rng.integers(len(TEXTS))]
    return "\n".join(lines)


def _mutate_number(text: str, rng: np.random.Generator) -> str:
    found = list(_NUMBER.finditer(text))
    if not found:
        return _mutate_lines(text, rng)
    one = found[rng.integers(len(found))]
    kind = rng.integers(4)
    if kind == 0:
        new = repr(float(one[0]) * float(rng.choice(FACTORS)))
    elif kind == 1:
        new = "9" * int(rng.choice([20, 400, 5000]))
    elif kind == 2:
        new = found[rng.integers(len(found))][0]
    else:
        new = str(NUMBERS[rng.integers(len(NUMBERS))])
    return text[: one.start()] + new + text[one.end() :]


def _mutate_word(text: str, rng: np.random.Generator) -> str:
    found = list(_WORD.finditer(text))
    if not found:
        return _mutate_lines(text, rng)
    one, other = (found[rng.integers(len(found))] for _ in range(2))
    new = other[0] if rng.random() < 0.6 else TEXTS[rng.integers(len(TEXTS))]
    return text[: one.start()] + new + text[one.end() :]
