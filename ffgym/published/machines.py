"""Identified parameters of two recorded machines: the EMPS ball-screw axis and a KUKA KR 300 R2500 ultra."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array


@dataclass(frozen=True, kw_only=True)
class EmpsModel:
    """Rigid carriage with Coulomb and viscous friction that may differ in both directions, link side.

    Reference:
        A. Janot, M. Gautier, M. Brunot, Data Set and Reference Models of EMPS, Workshop on Nonlinear System
        Identification Benchmarks, Eindhoven (2019), nonlinearbenchmark.org.
    """

    mass: float
    """Mass M of carriage, screw and motor, referred to the carriage [kg]."""
    viscous: tuple[float, float]
    """Viscous coefficients F_v forwards and backwards [N s/m]."""
    coulomb: tuple[float, float]
    """Coulomb friction F_c forwards and backwards, each without sign [N]."""


EMPS_SYMMETRIC = EmpsModel(mass=95.1089, viscous=(203.5034,) * 2, coulomb=(20.3935 - 3.1648, 20.3935 + 3.1648))
"""Published: Simulation_EMPS.m; its constant offset [N] is Coulomb friction that differs in both directions."""

EMPS_ASYMMETRIC = EmpsModel(mass=95.1540, viscous=(166.7061, 240.4236), coulomb=(20.1440, 20.6277))
"""Result of Script_IDIM_LS_Asym_Fric.m on DATA_EMPS.mat: the script is published, and its steps, repeated with
SciPy, give the four published numbers of the symmetric model to every printed digit and these for the asymmetric one.
The table in the authors' description was not at hand."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class AsymmetricFriction:
    r"""Static friction law with a constant offset, link side, one entry per joint.

    .. math:: \tau_f = f_{asym} + f_{vis} \dot q + f_{coul} \tanh(s_f \dot q) + f_a \tanh(f_b \dot q)

    Reference:
        J. Weigand, J. Ulmen, A. Janot, M. Ruskowski, real-time nonlinear parameter identification for an industrial
        robot (2021); ident_functions/nonlinear_differential_model.m in github.com/JonasWeigand/Robot_Identification
        (MIT, (c) 2021 Jonas Weigand).
    """

    offset: Array
    """f_asym [N m], shape (N,)."""
    viscous: Array
    """f_vis [N m s/rad], shape (N,)."""
    slow_step: Array
    """f_coul [N m], shape (N,): a step that takes about 1 / s_f to build up."""
    slow_steepness: float
    """s_f [s/rad]."""
    step: Array
    """f_a [N m], shape (N,): Coulomb friction, in effect."""
    steepness: Array
    """f_b [s/rad], shape (N,)."""

    def torque(self, dq: Array) -> Array:
        """Return friction torque, link side [N m], at joint speed `dq` [rad/s]; same shape (..., N)."""
        steps = self.slow_step * np.tanh(self.slow_steepness * dq) + self.step * np.tanh(self.steepness * dq)
        return self.offset + self.viscous * dq + steps


KR300_FRICTION = AsymmetricFriction(
    offset=np.array([4.263565, -16.601509, -17.669106, -11.538545, -0.324006, 10.579765]),
    viscous=np.array([1939.519615, 1729.851974, 1562.422907, 280.490109, 468.130927, 384.412293]),
    slow_step=np.array([31.648672, 117.464957, 85.651531, 49.736808, 111.061181, 5.28567]),
    slow_steepness=1.0,
    step=np.array([318.643872, 420.696049, 291.520378, 43.875213, 13.83128, 82.430339]),
    steepness=np.array([1146.094958, 47299.332216, 10086.058412, 3784.175097, 4043.446829, 3965.751457]),
)
"""Parameters that the authors identified, data/data_ref.mat of the same repository, to 1e-6."""
