"""Recordings as equations, and how near the description a fit stays: the parts that no fit shows on its own."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.identification.rigid_body import Filtering
from ffgym.diagnosis.identification.rigid_body.bodies import bodies_of
from ffgym.diagnosis.identification.rigid_body.observation import equations_of
from ffgym.diagnosis.identification.rigid_body.problem import choose_spread
from ffgym.diagnosis.identification.rigid_body.terms import DEFAULT_TERMS, elastic_motion, rigid_motion, terms_named
from ffgym.robot import RigidArm, load_robot, static_deflection
from tests.diagnosis.identification.rigid_body.recorded_arms import recorded, rigid, swing


def parameters(robot):
    return np.concatenate([body.parameters for body in bodies_of(robot)])


def test_links_hang_where_gravity_bends_the_joints(irb4600, arm):
    q = np.tile(irb4600.work_area.home, (50, 1))
    rest = rigid_motion(irb4600, q, 0 * q, 0 * q)
    bent = elastic_motion(irb4600, rest, parameters(irb4600), dt=0.01)
    sag = static_deflection(arm, q)
    np.testing.assert_allclose(bent.q - q, sag, atol=0.01 * np.abs(sag).max())
    assert np.abs(bent.q - q).max() > 1e-4
    np.testing.assert_array_equal(bent.motor_dq, rest.motor_dq)


def test_links_lead_and_lag_by_inertia_over_stiffness():
    """A sine of one axis without gravity: the link moves further than the motor by (w / w_r)^2."""
    robot = replace(load_robot("one_axis"), gravity=np.zeros(3))
    t, w = 0.001 * np.arange(2000)[:, None], 2 * np.pi * 1.0
    motion = rigid_motion(robot, np.sin(w * t), w * np.cos(w * t), -(w**2) * np.sin(w * t))
    bent = elastic_motion(robot, motion, parameters(robot), dt=0.001)
    resonance = robot.drive.joint_stiffness[0] / RigidArm(robot).mass_matrix(np.zeros((1, 1)))[0, 0, 0]
    np.testing.assert_allclose(bent.ddq[100:-100], (1 + w**2 / resonance) * motion.ddq[100:-100], atol=1e-3)


def test_rows_count_where_the_motor_moves_and_the_filters_know_what_is_around():
    robot, filtering = rigid(load_robot("two_link")), Filtering()
    path = swing(robot, 0)
    cut = recorded(robot, path).slice(5.0, 15.0)  # which begins and ends in motion
    equations = equations_of(robot, [cut], terms_named(DEFAULT_TERMS), filtering)
    near = np.abs(path.t - equations.t[:, None]) <= 1 / filtering.parallel.cutoff
    slowest = np.array([np.abs(path.dq)[rows].min(axis=0) for rows in near])
    end = filtering.parallel.settling / filtering.parallel.cutoff
    known = (np.minimum(equations.t - cut.t[0], cut.t[-1] - equations.t) >= end)[:, None]
    assert not np.any(equations.counts & (~known | (slowest < 0.5 * filtering.moving)))
    assert np.all(equations.counts | ~known | (slowest < 2 * filtering.moving))
    assert 0.4 < equations.counts.mean() < 0.9


def test_terms_that_are_not_fitted_stay_as_described():
    robot = rigid(load_robot("two_link"))
    recording = recorded(robot, swing(robot, 0))
    friction = equations_of(robot, [recording], terms_named(("coulomb", "viscous", "offset")))
    described = np.concatenate([robot.friction.coulomb, robot.friction.viscous, np.zeros(2)])
    left = np.where(friction.counts, friction.residual(described), 0.0)
    assert np.abs(left).max() < 0.01 * np.abs(friction.measured).max()


class Tables:
    """Stands for a problem whose held-out losses are known, spread by spread; blocks are rows."""

    rows = 100

    def __init__(self, losses):
        self.losses_of = {spread: np.array(values) for spread, values in losses.items()}

    def solve(self, counts, spread):
        return spread

    def losses(self, spread):
        return self.losses_of[spread]


@pytest.mark.parametrize(
    ("near", "chosen"),
    [([10.0, 12.0, 9.0, 11.5], 0.1), ([14.0, 15.0, 14.5, 14.2], 1.0)],
    ids=["as good", "worse in every block"],
)
def test_the_description_is_left_only_where_that_predicts_better_beyond_chance(near, chosen):
    tables = Tables({0.1: near, 1.0: [10.0, 11.0, 9.5, 11.0], 10.0: [11.0, 12.0, 10.5, 12.0]})
    trade_off = choose_spread(tables, np.array([0, 0, 1, 1]), spreads=(0.1, 1.0, 10.0))
    assert trade_off.chosen == chosen
    assert np.argmin(trade_off.errors) == 1
