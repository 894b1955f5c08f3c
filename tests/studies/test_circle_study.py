"""The circle study has one cell per law, position, radius and speed, and is the same every time."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.control import NoCompensation, StaticLuGre
from ffgym.core.errors import FFGymError
from ffgym.recordings.metrics import motor_error_rms, path_errors
from ffgym.robot import ModelOptions, RigidArm, compile_model, physics_fingerprint
from ffgym.studies import circle_references, circle_study, thesis_laws

SMALL = {"positions": ["p2"], "speeds": [0.1], "radii": [0.001, 0.003]}


@pytest.fixture(scope="module")
def study(irb4600):
    return circle_study(irb4600, **SMALL)


def test_there_is_one_cell_per_law_position_radius_and_speed(study):
    cells = [(c.agent, c.position, c.radius_mm, c.speed_mm_s) for c in study.cells]
    agents = ("none", "lugre_static", "lugre_dynamic")
    assert sorted(cells) == sorted((agent, "p2", radius, 100.0) for agent in agents for radius in (1.0, 3.0))
    assert study.recordings.keys() == {(agent, "p2", 0.1) for agent in agents}


def test_cells_are_the_metrics_of_the_recordings(study):
    for cell in study.cells:
        recording = study.recordings[cell.agent, cell.position, cell.speed_mm_s / 1e3]
        error = next(e for e in path_errors(recording) if e.radius * 1e3 == pytest.approx(cell.radius_mm, rel=1e-4))
        found = (cell.rms_mm, cell.max_mm, cell.rms_3d_mm, cell.max_3d_mm)
        assert found == tuple(1e3 * x for x in (error.rms, error.max, error.rms_3d, error.max_3d))
        assert error.speed * 1e3 == pytest.approx(cell.speed_mm_s, rel=1e-4)
        assert recording.header.meta["feedforward_law"] == cell.agent


def test_motor_errors_count_from_lead_in_to_lead_out(study):
    cell = study.select(agent="none", radius_mm=3.0)[0]
    recording = study.recordings["none", "p2", 0.1]
    (lead_in,) = [p for p in recording.phases_of("lead_in") if p.label == "lead-in 3 mm"]
    (lead_out,) = [p for p in recording.phases_of("lead_out") if p.label == "lead-out 3 mm"]
    assert cell.motor_rms_rad == motor_error_rms(recording.slice(lead_in.start, lead_out.end)).tolist()
    assert len(cell.motor_rms_rad) == 6


def test_two_runs_are_equal(irb4600, study):
    again = circle_study(irb4600, **SMALL, n_threads=1)
    assert again.cells == study.cells
    assert again.fingerprint == study.fingerprint
    assert all(again.recordings[key].equals(recording) for key, recording in study.recordings.items())


def test_a_cell_does_not_depend_on_what_else_is_simulated(irb4600, study):
    alone = circle_study(irb4600, **SMALL, laws=[StaticLuGre(irb4600.friction)])
    assert alone.cells == study.select(agent="lugre_static")


def test_select_finds_cells_by_their_fields(study):
    assert len(study.select(agent="none")) == 2
    assert len(study.select(agent="none", radius_mm=1.0)) == 1
    assert study.select(agent="nobody") == []
    assert study.select() == study.cells


def test_the_fingerprint_is_that_of_the_plant(irb4600, study):
    assert study.fingerprint == physics_fingerprint(compile_model(irb4600, ModelOptions(looks=False)))
    rigid = ModelOptions(looks=False, flexible=False)
    other = circle_study(irb4600, **SMALL, laws=[NoCompensation()], options=rigid)
    assert other.fingerprint == physics_fingerprint(compile_model(irb4600, rigid))
    assert other.cells != study.select(agent="none")


def test_progress_is_told_and_ends_at_the_total(irb4600):
    told = []
    circle_study(irb4600, **SMALL, laws=[NoCompensation()], progress=lambda done, total: told.append((done, total)))
    assert [done for done, _ in told] == sorted(done for done, _ in told)
    assert told[-1][0] == told[-1][1] > 0


def test_the_laws_of_the_thesis_know_the_robots_friction(irb4600):
    assert [law.name for law in thesis_laws(irb4600)] == ["none", "lugre_static", "lugre_dynamic"]
    assert thesis_laws(irb4600)[1].friction is irb4600.friction


def test_references_cover_positions_and_speeds(arm):
    references = circle_references(arm, speeds=[0.04, 0.1], radii=[0.001])
    assert references.keys() == {(p, v) for p in ("p1", "p2", "p3", "p4") for v in (0.04, 0.1)}
    for (position, _), reference in references.items():
        np.testing.assert_allclose(arm.tcp_position(reference.q[:1])[0], arm.robot.position(position), atol=1e-9)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"positions": ["p5"]}, "Unknown position 'p5'. Available: p1, p2, p3, p4"),
        ({"speeds": [0.0]}, "speed = 0.0 m/s"),
        ({"radii": []}, r"radii \[mm\] of one study"),
        ({"speeds": [20.0], "radii": [0.2]}, "joint j"),
        ({"laws": []}, "nothing to simulate"),
        ({"positions": []}, "positions of one study"),
        ({"speeds": [0.01, 0.0100000000001]}, r"speeds \[mm/s\] of one study"),
        ({"radii": [0.001, 0.001]}, r"radii \[mm\] of one study"),
    ],
)
def test_a_study_that_cannot_run_is_refused(irb4600, changes, message):
    with pytest.raises(FFGymError, match=message):
        circle_study(irb4600, **SMALL | changes)


def test_a_robot_without_work_area_has_no_circle_study(irb4600, one_axis):
    for robot in (one_axis, replace(irb4600, work_area=None)):
        with pytest.raises(FFGymError, match="has no work area for circles; use ffgym"):
            circle_study(robot)
        with pytest.raises(FFGymError, match="has no work area"):
            circle_references(RigidArm(robot))


def test_two_laws_of_one_name_are_refused(irb4600):
    laws = [StaticLuGre(irb4600.friction), StaticLuGre(irb4600.friction, steepness=50.0)]
    with pytest.raises(FFGymError, match="lugre_static"):
        circle_study(irb4600, **SMALL, laws=laws)


def test_the_full_study_has_108_cells(irb4600):
    study = circle_study(irb4600)
    assert len(study.cells) == 108
    assert len({(c.agent, c.position, c.radius_mm, c.speed_mm_s) for c in study.cells}) == 108
    assert len(study.recordings) == 36
    assert all(np.isfinite([c.rms_mm, c.max_mm, c.rms_3d_mm, c.max_3d_mm, *c.motor_rms_rad]).all() for c in study.cells)


def test_a_part_of_a_study_is_the_study_of_that_part(irb4600, study):
    part = study.only(laws=["none", "lugre_dynamic"], positions=["p2"], speeds=[0.1])
    laws = [law for law in thesis_laws(irb4600) if law.name != "lugre_static"]
    assert part.cells == circle_study(irb4600, laws=laws, **SMALL).cells
    assert list(part.recordings) == [("none", "p2", 0.1), ("lugre_dynamic", "p2", 0.1)]
    assert study.only().cells == study.cells


def test_parts_joined_are_the_whole_study(study):
    whole = study.only(laws=["none"]).join(study.only(laws=["lugre_static", "lugre_dynamic"]))
    assert whole.cells == study.cells
    assert whole.recordings == study.recordings


def test_a_part_that_the_study_lacks_is_refused(study):
    with pytest.raises(FFGymError, match=r"The study has no position 'p1', only \['p2'\]"):
        study.only(positions=["p1"])


def test_studies_that_overlap_or_are_of_unlike_robots_are_not_joined(study):
    with pytest.raises(FFGymError, match=r"Both studies have results of \('lugre_dynamic', 'p2', 0.1\)"):
        study.join(study.only(laws=["lugre_dynamic"]))
    with pytest.raises(FFGymError, match="unlike robots"):
        study.join(replace(study, recordings={}, fingerprint="another"))
