"""Table 6.1 of the thesis: the fifteen sines from which the friction of joint 1 was identified."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class FrictionRecord:
    """One row: motor speed A sin(2 pi f t), thesis (6.13)."""

    number: int
    """Data record."""
    amplitude: float
    """A, motor side [rad/s]."""
    frequency: float
    """f [Hz]."""


_AMPLITUDES = (1.3, 5.0, 10.0)
_FREQUENCIES = (0.25, 0.5, 1.0, 2.0, 5.0)

FRICTION_RECORDS = tuple(
    FrictionRecord(number=5 * i + j + 1, amplitude=amplitude, frequency=frequency)
    for i, amplitude in enumerate(_AMPLITUDES)
    for j, frequency in enumerate(_FREQUENCIES)
)
"""The table. Record 11 is printed with A = 5, as record 6; here it has A = 10, as the pattern and figure 6.5e say,
which shows 10 sin(2 pi 0.25 t) among the validation records."""

ESTIMATION_RECORDS = (2, 4, 7, 9, 12, 14)
"""Set D of the thesis, from which the parameters were estimated; the other records validate."""
