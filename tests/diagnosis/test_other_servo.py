"""A servo whose torque no gains of the documented one explain."""

from dataclasses import replace

import pytest

from ffgym.diagnosis.procedure import shows_other_servo
from ffgym.diagnosis.result import Level
from tests.diagnosis.result_samples import full_diagnosis


@pytest.mark.parametrize(
    ("effect", "channel", "before", "after", "is_other"),
    [
        ("servo_gains", "servo", 500.0, 55.0, True),  # a cascade
        ("servo_gains", "servo", 190.0, 1.4, False),  # other gains of the documented servo
        ("servo_gains", "servo", 5000.0, 55.0, False),
        ("servo_gains", "servo", 20.0, 9.0, False),
        ("load_friction", "servo", 500.0, 55.0, False),
        ("servo_gains", "torque", 500.0, 55.0, False),
    ],
)
def test_gains_that_leave_much_of_a_servos_torque_are_those_of_another_servo(effect, channel, before, after, is_other):
    found = full_diagnosis()
    noise = 0.01
    level = Level(
        channel=channel,
        component="j2",
        unit="N m",
        measured=600 * noise,
        noise_floor=noise,
        before=before * noise,
        after=after * noise,
    )
    causes = (replace(found.causes[0], effect=effect),)
    assert shows_other_servo(replace(found, causes=causes, levels=(level,))) is is_other
