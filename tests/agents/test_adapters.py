"""Families that adapt to a machine: what one lap tells of it is worth something on other motions."""

import numpy as np
import pytest

from ffgym.agents.adapters import ADAPTERS
from ffgym.agents.amortised.draws import draw_machine
from ffgym.agents.elastic import elastic_law
from ffgym.agents.trials import RigTrial
from ffgym.leaderboard.adaptation.protocol import lap, score, scored_motions
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import Run, SimulatedRig, sensors_of, simulate


@pytest.mark.parametrize("name", ["amortised", pytest.param("fitted", marks=pytest.mark.slow)])
def test_one_lap_on_a_drawn_machine_halves_the_error_of_elastic_feed_forward(name):
    arm = RigidArm(load_robot("irb4600_60_205_arm_drives"))
    machine = draw_machine(arm.robot, np.random.default_rng(777))
    rig = SimulatedRig(arm=arm, machine=machine, sensors=sensors_of(arm.robot))
    [adapter] = [each for each in ADAPTERS if each.name == name]
    law, trial = adapter.practise(arm, RigTrial(rig=rig, n_threads=1), laps=1)
    assert trial.robot_seconds == lap(arm).duration
    motion = scored_motions(arm)[0]
    runs = [Run(reference=motion, law=each) for each in (elastic_law(arm), law)]
    base, adapted = (score(each) for each in simulate(runs, arm=arm, machine=machine, n_threads=1))
    assert adapted < 0.5 * base
