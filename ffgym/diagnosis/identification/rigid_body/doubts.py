"""What speaks against a rigid-body fit, in sentences: a fit always gives numbers, also where none are right."""

import numpy as np

from ffgym.diagnosis.identification.rigid_body.torque_errors import TorqueErrors
from ffgym.diagnosis.identification.rigid_body.trade_off import TradeOff
from ffgym.robot import RobotDescription

UNEXPLAINED = 0.2
"""Share of a motor's RMS torque that a fit may leave; chosen: of the run that is fitted it leaves at most 4 % on the
recorded machines of docs/rigid_body_identification.md, and 32 % to 103 % where the torque has the wrong sign."""


def doubts_about(robot: RobotDescription, errors: TorqueErrors, trade_off: TradeOff) -> tuple[str, ...]:
    """Sentences about motors whose torque is left unexplained, and a description that is farther off than was tried."""
    left = errors.identified > UNEXPLAINED * errors.measured
    doubts = [
        f"{robot.joints[j]}: {errors.identified[j] / errors.measured[j]:.0%} of its torque is left unexplained. Look "
        "for a wrong sign, unit, side of the gearbox or gear ratio, or for a torque that is no rigid body's."
        for j in np.flatnonzero(left)
    ]
    if len(trade_off.spreads) > 1 and trade_off.chosen == trade_off.spreads.max():
        doubts.append(
            f"Held-out parts are predicted best with the largest spread that was tried, {trade_off.chosen:g}: masses "
            "or rotors of the description, or the unit of the torque, are off by a factor. Begin with better ones."
        )
    return tuple(doubts)
