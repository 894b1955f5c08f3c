"""The torque correction that a linear model finds best for a measured error: the step of norm-optimal learning control.

Source: Amann, Owens, Rogers (1996), Iterative learning control using optimal feedback and feedforward actions, Int. J.
Control 65(2): the minimum over all samples of a motion is found by one pass backward and one forward in time, with the
gain of a Riccati equation. Departure: the gain is the stationary one, as if the machine rested on after the motion.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, solve_discrete_are

from ffgym.agents.per_task.torque_response import TorqueResponse
from ffgym.core.errors import FFGymError, check_number
from ffgym.core.types import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class NormOptimalStep:
    r"""Least-squares correction :math:`\Delta u` of the torque for an error e, y the answer of the model.

    .. math:: \min_{\Delta u} \sum_k \frac{|e_k - y_k|^2}{\epsilon^2} + \sum_k \sum_i \frac{\Delta u_{k,i}^2}{f_{c,i}^2}
    """

    closed: Array
    """Transition of the model under the optimal feedback, A - B K, shape (S, S)."""
    gain: Array
    """Optimal feedback K, shape (N, S)."""
    entry: Array
    """B, shape (S, N)."""
    inverse: Array
    """Inverse of the cost of a torque, its consequences included, shape (N, N)."""
    from_error: Array
    """What an error asks of the torque of its sample, D^T / epsilon^2, shape (N, m)."""
    to_costate: Array
    """What an error asks of all torques before it, (C - D K)^T / epsilon^2, shape (S, m)."""

    @classmethod
    def of(cls, response: TorqueResponse, tolerance: float, torque_scale: Array) -> "NormOptimalStep":
        """Solve the Riccati equation.

        Args:
            response: the model.
            tolerance: error epsilon that weighs as much as a correction of one `torque_scale`, unit of the error.
            torque_scale: f_c, e.g. the motors' Coulomb friction [N m], shape (N,).

        Raises:
            FFGymError: if the tolerance is not positive, or there is no solution.
        """
        tolerance = check_number("tolerance", tolerance, unit="rad or m", low=0.0, open_low=True)
        a, b, c, d = response.transition, response.entry, response.output, response.direct
        c_weighted, d_weighted = c.T / tolerance**2, d.T / tolerance**2
        own = np.diag(1 / torque_scale**2) + d_weighted @ d
        try:
            cost = solve_discrete_are(a, b, c_weighted @ c, own, s=c_weighted @ d)
        except LinAlgError as error:
            raise FFGymError(
                f"No torque correction can be computed: {error} The servo must hold every motor (position_gain > 0), "
                f"and the tolerance of {tolerance} must be neither far too small nor far too large."
            ) from error
        inverse = np.asarray(np.linalg.inv(own + b.T @ cost @ b), dtype=np.float64)
        gain = inverse @ (d_weighted @ c + b.T @ cost @ a)
        return cls(
            closed=a - b @ gain,
            gain=gain,
            entry=b,
            inverse=inverse,
            from_error=d_weighted,
            to_costate=c_weighted - gain.T @ d_weighted,
        )

    def correction(self, error: Array) -> Array:
        """Torque to add [N m], shape (T, N), for an error (T, m); zero at sample 0, before which none is set."""
        asked, before = error @ self.from_error.T, error @ self.to_costate.T
        costate = np.zeros(len(self.closed))
        push = np.zeros_like(asked)
        for k in range(len(error) - 1, 0, -1):
            push[k] = self.inverse @ (self.entry.T @ costate + asked[k])
            costate = self.closed.T @ costate + before[k]
        state = np.zeros(len(self.closed))
        correction = np.zeros_like(push)
        for k in range(1, len(error)):
            correction[k] = push[k] - self.gain @ state
            state = self.closed @ state + self.entry @ push[k]
        return correction
