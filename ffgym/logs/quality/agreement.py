"""Checks of columns that say the same in different words: motion, torque."""

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from ffgym.logs.quality.check import Check, NotJudgedError, Seen
from ffgym.logs.quality.kinship import CLOSE, Kind, Stranger, columns_of
from ffgym.logs.quality.log import Log
from ffgym.logs.quality.signals import motion_signals, torque_signals

_WAYS_OUT: Mapping[Kind, str] = {
    "units": "Convert it where the data enter",
    "side": "Correct position_side, torque_semantics or gear_ratio of the header, or convert the column",
    "sign": "Turn its sign",
    "permutation": "Give the columns the names of their joints",
    "scale": "Look for another gear ratio, another unit, or another sensor",
    "agreement": "Look for a log of another run, or a column of another quantity",
}


def _judge(kind: Kind) -> Callable[[Log], Iterator[Seen]]:
    def judge(log: Log) -> Iterator[Seen]:
        groups = [signals for signals in (motion_signals(log), torque_signals(log)) if len(signals.values) > 1]
        if not groups:
            raise NotJudgedError("no two columns say the same of a joint that moves")
        for signals in groups:
            odd = [stranger for stranger in signals.strangers if stranger.kind == kind]
            yield from (_seen(log, stranger) for stranger in odd)
            if not odd:
                yield Seen(value=0.0, message="")

    return judge


def _seen(log: Log, odd: Stranger) -> Seen:
    joint = log.joints[odd.joint]
    columns, others = columns_of(odd.family, joint), columns_of(odd.other, log.joints[odd.other_joint])
    name, other = " + ".join(columns), " + ".join(others)
    if odd.kind == "agreement":
        figure = f"correlates with {other} by {odd.value:.3g}, must by 0.8"
    elif odd.kind == "permutation":
        figure = f"goes like {other} and {odd.value:.3g} times its own"
    else:
        figure = f"is {odd.value:.5g} times what {other} says, must be the same"
    message = f"{name} {figure}: {odd.text}. {_WAYS_OUT[odd.kind]}."
    value = 0.5 if odd.kind == "agreement" and odd.family.endswith("effort") else 1.0
    value = abs(np.log(abs(odd.value))) if odd.kind == "scale" else value
    return Seen(value=float(value), message=message, columns=(*columns, *others), joint=joint)


_FACTOR = "columns of one quantity agree to some percent; a factor of another unit, side or sign is far outside"
_TWIN = (
    "a column that is another joint's at a slope of 1 and correlates with it by 0.98, not with its own, is that one's"
)
_ALONE = (
    "columns of one quantity correlate by 0.97 and more; below 0.8 they are of different runs; commanded torques count "
    "half: what some controllers command lacks friction"
)

_FAULTS: Mapping[Kind, tuple[str, str]] = {
    "units": ("Columns in another unit", _FACTOR),
    "side": ("Columns of the other side of the gearbox", _FACTOR),
    "sign": ("Columns of the opposite sign", _FACTOR),
    "permutation": ("Columns of another joint", _TWIN),
    "agreement": ("Columns that fit no other", _ALONE),
}

AGREEMENT = (
    *(
        Check(
            name=kind,
            figure=figure,
            unit="columns",
            flag=0.25 if kind == "agreement" else 0.5,
            refuse=0.5,
            why=why,
            judge=_judge(kind),
        )
        for kind, (figure, why) in _FAULTS.items()
    ),
    Check(
        name="scale",
        figure="Size of a column against what others say, as |ln|",
        unit="1",
        flag=float(np.log1p(CLOSE)),
        why="recorded axes of a coupled wrist differ from their set-points by up to 12 %; 5 % deserves a look",
        judge=_judge("scale"),
    ),
)
"""Checks of columns against each other."""
