"""A file that is no serial arm is one error of one line, which names the file, the thing and the way out."""

import re

import mujoco
import pytest

from ffgym.core.errors import FFGymError
from ffgym.robot.arm_file import read_arm
from tests.robot.arm_file.arm_file_samples import FILES, write_stl
from tests.robot.arm_file.broken_arms import (
    ARM,
    BROKEN,
    CHAIN,
    GEOM,
    MESH,
    WEIGHT,
    body,
    joint,
    link,
    mjcf,
    shape,
    urdf,
)


def refusal(path, *args, **options):
    """The error that reading raises: one line that starts with the file."""
    with pytest.raises(FFGymError) as caught:
        read_arm(path, *args, **options)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    return message


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_file_is_one_clear_error(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    text, expected = BROKEN[name]
    path = tmp_path / ("arm.urdf" if "<robot" in text else "arm.xml")
    path.write_text(text, encoding="utf-8")
    assert expected.format(folder=tmp_path) in refusal(path)
    assert list(tmp_path.iterdir()) == [path]  # MuJoCo writes no MUJOCO_LOG.TXT


@pytest.mark.parametrize(
    ("content", "way_out"), [(b"", "is empty"), (b"solid nothing", "Copy or make the mesh again"), (bytes(84), "mesh")]
)
@pytest.mark.parametrize("kind", ["MJCF", "URDF"])
def test_a_mesh_that_cannot_be_read_is_one_clear_error_with_a_way_out(tmp_path, kind, content, way_out):
    (tmp_path / "hull.stl").write_bytes(content)
    texts = {
        "MJCF": mjcf(body("a", mass=GEOM), MESH),
        "URDF": urdf(link("a", shape("hull.stl")), link("b"), joint("j", "a", "b")),
    }
    path = tmp_path / "arm.xml"
    path.write_text(texts[kind], encoding="utf-8")
    message = refusal(path)
    assert way_out in message
    assert 'looks = "none"' in message


def test_without_looks_missing_meshes_do_not_matter(tmp_path):
    for name, text in {
        "arm.xml": mjcf(body("a", body("b", mass=WEIGHT + GEOM)), MESH),
        "arm.urdf": urdf(link("a", shape("gone.stl")), link("b"), joint("j", "a", "b")),
    }.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
        assert read_arm(tmp_path / name, looks=False).geoms == ()
        assert "missing" in refusal(tmp_path / name)


def test_a_mesh_that_a_mass_comes_from_matters_without_looks(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(mjcf(body("a", mass=GEOM), MESH), encoding="utf-8")
    assert "The mesh 'hull' is missing" in refusal(path, looks=False)
    write_stl(tmp_path / "hull.stl")
    with_looks, without = read_arm(path), read_arm(path, looks=False)
    mass = "links.mass"
    assert without.quantities[mass].value[0] == pytest.approx(1000 * 0.1**3 / 6, rel=1e-5)  # of water
    assert with_looks.quantities[mass].value == without.quantities[mass].value


def test_shapes_without_mass_do_not_matter_without_looks_even_where_others_weigh(tmp_path):
    path = tmp_path / "arm.xml"
    for weightless in ("density='0'", "mass='0'"):
        mesh = f"<geom type='mesh' mesh='hull' {weightless}/>"
        path.write_text(mjcf(body("a", mass=f"<geom size='0.1' mass='2'/>{mesh}"), MESH), encoding="utf-8")
        assert read_arm(path, looks=False).quantities["links.mass"].value == [2.0]


def test_masses_come_from_shapes_where_the_file_says_so(tmp_path):
    path = tmp_path / "arm.xml"
    text = mjcf(body("a", mass=WEIGHT + "<geom size='1' mass='7'/>"), "<compiler inertiafromgeom='true'/>")
    path.write_text(text, encoding="utf-8")
    for looks in (True, False):
        assert read_arm(path, looks=looks).quantities["links.mass"].value == [7.0]


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        (["elbow"], "Unknown joint 'elbow'. Available: elbow_joint, left, right, shoulder_lift_joint"),
        (["elbow_joint", "shoulder_pan_joint"], "must go from the base outwards, but 'elbow_joint' is moved by"),
        (["shoulder_pan_joint", "left", "right"], "'right' does not follow 'left'"),
        (["elbow_joint", "elbow_joint"], "must name at least one joint, and each once"),
        ([], "must name at least one joint"),
        (["elbow_joint", "left"], "The constraint 'fingers' (equality, mimic) ties joint 'left' to another"),
    ],
)
def test_joints_that_are_no_chain_of_the_file_are_refused(joints, message):
    assert message in refusal(FILES / "ur_like.xml", joints, looks=False)


def test_one_name_in_place_of_a_list_is_refused():
    with pytest.raises(FFGymError, match=re.escape("joints = 'elbow_joint' must be a list of names, ['elbow_joint']")):
        read_arm(FILES / "ur_like.xml", "elbow_joint")


def test_a_file_that_is_not_there_is_refused(tmp_path):
    assert "no such file" in refusal(tmp_path / "arm.urdf")
    assert "is a folder, must be a file" in refusal(tmp_path)


def test_an_mjcf_file_must_be_called_xml(tmp_path):
    path = tmp_path / "arm.mjcf"
    path.write_text(mjcf(CHAIN), encoding="utf-8")
    assert "Give it a name that ends in .xml" in refusal(path)


def test_joints_that_are_no_hinges_or_slides_may_be_held(tmp_path):
    parts = [link("a"), link("b"), link("c"), joint("j", "a", "b", "floating"), joint("k", "b", "c")]
    path = tmp_path / "arm.urdf"
    path.write_text(urdf(*parts), encoding="utf-8")
    arm = read_arm(path, ["k"])
    assert arm.joints == ("k",)
    assert arm.quantities["base.mass"].value == 2.0
    path = tmp_path / "robot.xml"
    path.write_text(mjcf(body("a", body("b"), "<freejoint/>")), encoding="utf-8")
    assert read_arm(path, ["j_b"]).quantities["base.mass"].value > 0


def test_constraints_that_bind_nothing_that_moves_are_no_loop(tmp_path):
    held = body("c", body("d"), "<joint name='j_c' axis='1 0 0'/>")
    ties = [
        "<weld body1='b' body2='a' active='false'/>",  # switched off
        "<connect body1='foot' body2='world' anchor='0 0 0'/>",  # the base and the world
        "<connect body1='d' body2='b' anchor='0 0 0'/>",  # a linkage in one link, whose joints are held
        "<joint joint1='j_c' joint2='j_d'/>",
        "<joint joint1='j_c'/>",
    ]
    arm = body("foot", body("a", body("b", held)), "")
    path = tmp_path / "arm.xml"
    path.write_text(mjcf(arm, f"<equality>{''.join(ties)}</equality>"), encoding="utf-8")
    assert read_arm(path, ["j_a", "j_b"]).joints == ("j_a", "j_b")


def test_names_that_are_no_text_are_refused(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_bytes(mjcf(CHAIN).encode().replace(b"'a'", b"'\x80'"))
    assert "Names in it are not UTF-8 text" in refusal(path)


def test_lines_are_named_where_they_are_those_of_the_file(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text("\n\n" + mjcf(body("a", mass="")), encoding="utf-8")
    assert ", line 3." in refusal(path)
    path.write_text("<!-- -->\n" + urdf(ARM).replace("mass value='1'", "mass value='x'"), encoding="utf-8")
    assert refusal(path).endswith("bad format in attribute 'value'; Element 'mass'.")


def test_warnings_of_mujoco_are_notes_and_whoever_listened_before_still_does(tmp_path):
    def listener(message):
        raise AssertionError(message)

    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(listener)
    try:
        path = tmp_path / "arm.urdf"
        path.write_text(urdf(ARM).replace("lower='-1' upper='1'", "lower='0' upper='0'"), encoding="utf-8")
        arm = read_arm(path)
        assert mujoco.get_mju_user_warning() is listener
    finally:
        mujoco.set_mju_user_warning(before)
    assert arm.notes == ("joint 'j' has equal lower and upper limits, limit ignored",)
