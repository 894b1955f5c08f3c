"""Parameters of the EMPS benchmark, a ball-screw axis: what its authors' scripts identify, link side.

A. Janot, M. Gautier, M. Brunot, Data Set and Reference Models of EMPS, Workshop on Nonlinear System Identification
Benchmarks, Eindhoven (2019), nonlinearbenchmark.org.
"""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class EmpsModel:
    """Rigid carriage with Coulomb and viscous friction that may differ in both directions."""

    mass: float
    """Carriage, screw and motor as the carriage feels them M [kg]."""
    viscous: tuple[float, float]
    """Forwards and backwards F_v [N s/m]."""
    coulomb: tuple[float, float]
    """Forwards and backwards F_c, each without sign [N]."""


def _symmetric(mass: float, viscous: float, coulomb: float, offset: float) -> EmpsModel:
    """A constant offset [N] is Coulomb friction that differs in both directions."""
    return EmpsModel(mass=mass, viscous=(viscous, viscous), coulomb=(coulomb + offset, coulomb - offset))


EMPS_SYMMETRIC = _symmetric(mass=95.1089, viscous=203.5034, coulomb=20.3935, offset=-3.1648)
"""Published: Simulation_EMPS.m."""

EMPS_ASYMMETRIC = EmpsModel(mass=95.1540, viscous=(166.7061, 240.4236), coulomb=(20.1440, 20.6277))
"""What Script_IDIM_LS_Asym_Fric.m computes from DATA_EMPS.mat: the script is published, and its steps, repeated with
SciPy, give the four published numbers of the symmetric model to every printed digit and these for the asymmetric one.
The table in the authors' description was not at hand."""
