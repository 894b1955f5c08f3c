"""A description looks as its file: every shape and every corner of a mesh is where MuJoCo itself draws it."""

import mujoco
import numpy as np
import pytest

from ffgym.robot import ModelOptions, compile_model
from ffgym.robot.arm_file import read_arm
from tests.robot.arm_file.arm_file_samples import FILES, UR_JOINTS, described, write_stl

ORANGE = (0.96, 0.47, 0.15, 1.0)
RIGID = ModelOptions(flexible=False, friction=False, servo=False)


@pytest.fixture
def ur_mjcf(tmp_path):
    """The UR-like MJCF file with its mesh."""
    path = tmp_path / "ur_like.xml"
    path.write_text((FILES / "ur_like.xml").read_text())
    write_stl(tmp_path / "meshes" / "base.stl")
    return path


def placed(model, names, q, geom):
    """Centre, axes and mesh corners of a geom in the world, with the named joints at q."""
    data = mujoco.MjData(model)
    data.qpos[:] = 0
    for name, value in zip(names, q, strict=True):
        data.joint(name).qpos = value
    mujoco.mj_kinematics(model, data)
    turn = data.geom_xmat[geom].reshape(3, 3)
    mesh = model.geom_dataid[geom]
    if mesh < 0:
        return data.geom_xpos[geom], turn, np.empty((0, 3))
    start, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    corners = data.geom_xpos[geom] + model.mesh_vert[start : start + count] @ turn.T
    return data.geom_xpos[geom], turn, corners


def geoms_of(model, body_of_link):
    """Geoms of the arm by body."""
    return [g for g in range(model.ngeom) if model.body(model.geom_bodyid[g]).name in body_of_link]


def test_primitives_are_where_the_file_has_them():
    robot = described(FILES / "kr_like.xml", frame="tip", looks="file")
    ours, theirs = compile_model(robot, RIGID), mujoco.MjModel.from_xml_path(str(FILES / "kr_like.xml"))
    motors = [f"{j}_motor" for j in robot.joints]
    own = [g for g in range(ours.ngeom) if ours.geom_type[g] != mujoco.mjtGeom.mjGEOM_PLANE.value]
    assert len(own) == theirs.ngeom
    q = np.random.default_rng(0).uniform(-2, 2, 6)
    for g in range(theirs.ngeom):
        centre, turn, _ = placed(theirs, robot.joints, q, g)
        match = [h for h in own if np.allclose(placed(ours, motors, q, h)[0], centre, atol=1e-9)]
        match = [h for h in match if ours.geom_type[h] == theirs.geom_type[g]]
        assert match
        axes = placed(ours, motors, q, match[0])[1]
        symmetric = theirs.geom_type[g] != mujoco.mjtGeom.mjGEOM_BOX.value
        np.testing.assert_allclose(np.abs((axes.T @ turn)[2, 2]), 1, atol=1e-9)
        if not symmetric:
            np.testing.assert_allclose(axes, turn, atol=1e-9)
        np.testing.assert_allclose(ours.geom_size[match[0]][:2], theirs.geom_size[g][:2], atol=1e-12)


def test_meshes_are_where_the_file_has_them(ur_mjcf):
    robot = described(ur_mjcf, UR_JOINTS, looks="file")
    spec = mujoco.MjSpec.from_file(str(ur_mjcf))
    spec.material("jointgray").textures = [""] * 10
    spec.delete(spec.textures[0])
    theirs, ours = spec.compile(), compile_model(robot, RIGID)
    q = np.random.default_rng(1).uniform(-2, 2, 6)
    for body, other in (("base", "base"), ("shoulder_link", "shoulder_link")):
        (g,) = [g for g in geoms_of(ours, [body]) if ours.geom_dataid[g] >= 0]
        (h,) = [h for h in geoms_of(theirs, [other]) if theirs.geom_dataid[h] >= 0]
        corners = placed(ours, [f"{j}_motor" for j in UR_JOINTS], q, g)[2]
        expected = placed(theirs, UR_JOINTS, q, h)[2]
        np.testing.assert_allclose(sort_rows(corners), sort_rows(expected), atol=1e-7)  # meshes have single precision


def test_a_mesh_that_is_used_twice_is_kept_once(ur_mjcf):
    robot = described(ur_mjcf, UR_JOINTS, looks="file")
    meshes = [geom.mesh for geom in robot.geoms if geom.mesh is not None]
    assert len(meshes) == 2
    assert meshes[0] is meshes[1]
    assert compile_model(robot).nmesh == 1


def test_visual_geoms_are_preferred_to_those_that_collide(ur_mjcf):
    looks = read_arm(ur_mjcf, UR_JOINTS).geoms
    assert [(g.body, g.type) for g in looks[:3]] == [
        ("base", "mesh"),
        ("shoulder_link", "mesh"),
        ("upper_arm_link", "capsule"),
    ]
    assert looks[0].colour == pytest.approx((0.033, 0.033, 0.033, 1))
    both = "<geom type='box' size='1 1 1' contype='0' conaffinity='0'/><geom size='1'/>"
    ur_mjcf.write_text(f"<mujoco><worldbody><body><joint/>{both}</body></worldbody></mujoco>")
    assert [geom.type for geom in read_arm(ur_mjcf).geoms] == ["box"]


def test_shapes_of_urdf_are_read_with_colour_scale_and_origin(tmp_path):
    path = tmp_path / "kr_like.urdf"
    path.write_text((FILES / "kr_like.urdf").read_text())
    corners = write_stl(tmp_path / "meshes" / "base.stl", size=100.0)  # mm
    base, link = read_arm(path).geoms[:2]
    assert base.colour == pytest.approx(ORANGE)
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, np.array(base.rotation))
    found = base.mesh.vertices @ turn.reshape(3, 3).T + base.pos
    np.testing.assert_allclose(sort_rows(found), sort_rows(corners / 1000), atol=1e-7)
    assert (link.body, link.type, link.size) == ("link_1", "capsule", (0.05,))
    np.testing.assert_allclose([link.pos, link.end], [[0.02, 0, -0.15], [0.02, 0, -0.05]], atol=1e-15)
    assert link.colour == pytest.approx(ORANGE)  # a material that another link defines


def test_a_package_is_any_folder_above_the_file_and_collada_gives_way_to_collision_shapes(tmp_path):
    path = tmp_path / "src" / "ur_like_description" / "urdf" / "ur_like.urdf"
    write_stl(tmp_path / "src" / "ur_like_description" / "meshes" / "base.stl")
    path.parent.mkdir()
    path.write_text((FILES / "ur_like.urdf").read_text())
    arm = read_arm(path)
    assert [g.body for g in arm.geoms if g.type == "mesh"] == ["base"]
    assert arm.notes == ()
    elsewhere = tmp_path / "ws" / "ur.urdf"
    write_stl(tmp_path / "ur_like_description" / "meshes" / "base.stl")
    elsewhere.parent.mkdir()
    elsewhere.write_text((FILES / "ur_like.urdf").read_text())
    assert len(read_arm(elsewhere).geoms) == len(arm.geoms)


def test_a_mesh_may_be_given_by_its_full_path(tmp_path):
    write_stl(tmp_path / "mesh" / "hull.stl")
    text = (FILES / "kr_like.urdf").read_text()
    for uri in (f"file://{tmp_path}/mesh/hull.stl", f"{tmp_path}/mesh/hull.stl"):
        (tmp_path / "arm.urdf").write_text(text.replace("meshes/base.stl", uri))
        assert read_arm(tmp_path / "arm.urdf").geoms[0].type == "mesh"


def test_settings_of_the_file_hide_neither_looks_nor_frames(ur_mjcf):
    expected = read_arm(ur_mjcf, UR_JOINTS)
    text = ur_mjcf.read_text().replace("autolimits", 'fusestatic="true" discardvisual="true" autolimits')
    ur_mjcf.write_text(text)
    arm = read_arm(ur_mjcf, UR_JOINTS)
    assert [(geom.body, geom.type) for geom in arm.geoms] == [(geom.body, geom.type) for geom in expected.geoms]
    assert set(arm.frames) == set(expected.frames)


def test_a_link_whose_meshes_cannot_be_read_is_noted(tmp_path):
    path = tmp_path / "ur_like.urdf"
    path.write_text((FILES / "ur_like.urdf").read_text().replace("base.stl", "base.dae"))
    arm = read_arm(path)
    assert "base" not in {geom.body for geom in arm.geoms}
    assert arm.notes == (
        "link 'base_link_inertia' is not drawn: its meshes are in formats other than .stl, .obj, .msh",
    )


def test_one_mesh_that_cannot_be_read_is_enough_for_collision_shapes(tmp_path):
    text = (FILES / "ur_like.urdf").read_text().replace("base.stl", "base.dae")
    sphere = '<visual><geometry><sphere radius="0.3"/></geometry></visual>'
    box = '<collision><geometry><box size="0.2 0.4 0.6"/></geometry></collision>'
    text = text.replace('<link name="base_link_inertia">', f'<link name="base_link_inertia">{sphere}{box}')
    (tmp_path / "arm.urdf").write_text(text)
    base = [geom for geom in read_arm(tmp_path / "arm.urdf").geoms if geom.body == "base"]
    assert [(geom.type, geom.size) for geom in base] == [("box", (0.1, 0.2, 0.3))]


def test_shapes_turn_with_roll_pitch_and_yaw_about_fixed_axes(tmp_path):
    text = (FILES / "ur_like.urdf").read_text().replace("base.stl", "base.dae")
    (tmp_path / "arm.urdf").write_text(text.replace('rpy="0 0 0" xyz="-0.2125', 'rpy="0.3 -0.4 0.5" xyz="-0.2125'))
    box = next(geom for geom in read_arm(tmp_path / "arm.urdf").geoms if geom.type == "box")
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, np.array(box.rotation))
    link = turn_about(2, np.pi) @ turn_about(0, 1.570796327)
    expected = link @ turn_about(2, 0.5) @ turn_about(1, -0.4) @ turn_about(0, 0.3)
    np.testing.assert_allclose(turn.reshape(3, 3), expected, atol=1e-9)


def test_looks_weigh_nothing(ur_mjcf):
    robot = described(ur_mjcf, UR_JOINTS, looks="file")
    seen, unseen = compile_model(robot), compile_model(robot, ModelOptions(looks=False))
    np.testing.assert_array_equal(seen.body_mass, unseen.body_mass)
    np.testing.assert_array_equal(seen.body_inertia, unseen.body_inertia)


def turn_about(axis, angle):
    """Rotation matrix about a coordinate axis."""
    c, s = np.cos(angle), np.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[i, i], turn[i, j], turn[j, i], turn[j, j] = c, -s, s, c
    return turn


def sort_rows(points):
    """Points in an order that rounding does not change."""
    return points[np.lexsort(np.round(points, 6).T)]
