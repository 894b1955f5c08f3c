"""What elastic feed-forward leaves on a motion that begins far from where it works: the sag of its start, turned."""

import numpy as np

from ffgym.agents.elastic import elastic_law
from ffgym.paths.motions import load_motion
from ffgym.robot import RigidArm, static_deflection
from ffgym.simulation import Run, simulate


def test_far_from_the_start_nothing_but_its_turned_sag_is_left(arm):
    reference = load_motion(arm, "cut_bracket").reference
    model = RigidArm(reference.robot)
    (recording,) = simulate([Run(reference=reference, law=elastic_law(model))], arm=model, record_dt=0.004)
    error = np.stack(
        [recording[f"tcp.position.{axis}"] - recording[f"tcp_reference.position.{axis}"] for axis in "xyz"], axis=1
    )
    bent = reference.q + static_deflection(model, reference.q[:1])
    sag = model.tcp_position(bent) - model.tcp_position(reference.q)
    left = np.linalg.norm((error - error[0]) - (sag - sag[0]), axis=1)
    assert np.linalg.norm(sag - sag[0], axis=1).max() > 0.2e-3  # the joints stay bent as at the start
    assert np.sqrt(np.mean(left**2)) < 5e-6
