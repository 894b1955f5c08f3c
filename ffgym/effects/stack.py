"""Effects of many machines stacked into one: rows of parameters, null where a machine does not have the effect."""

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from ffgym.effects.effect import Effect

E = TypeVar("E", bound=Effect)


def stack_effects(kind: type[E], members: Sequence[E | None], n_joints: int) -> E:
    """Stack effects of one kind: parameters get B rows, (B, N) per joint, so that one formula serves B machines.

    Args:
        kind: class of all members.
        members: the effect of each machine; None for a machine without it.
        n_joints: number of joints N.
    """
    together = object.__new__(kind)
    for known in kind.parameters().values():
        shape = known.shape(n_joints)
        none = np.full(shape, known.neutral)
        rows = np.stack([none if member is None else getattr(member, known.name) for member in members])
        object.__setattr__(together, known.name, rows if shape else rows[:, None])
    return together


def by_kind(machines: Sequence[Sequence[E]]) -> list[tuple[type[E], list[E | None]]]:
    """Sort effects of all machines into kinds; a second effect of one kind on a machine goes into a second row.

    Link-side kinds come first, since they change the load that others depend on; then kinds come by name, so that sums
    do not depend on the order in which effects were listed.
    """
    rows: dict[tuple[type[E], int], list[E | None]] = {}
    for i, effects in enumerate(machines):
        count: dict[type[E], int] = {}
        for effect in effects:
            kind = type(effect)
            key = (kind, count.setdefault(kind, 0))
            rows.setdefault(key, [None] * len(machines))[i] = effect
            count[kind] += 1
    ordered = sorted(rows, key=lambda key: (key[0].side != "link", key[0].name, key[1]))
    return [(key[0], rows[key]) for key in ordered]
