"""URDF files in which inertias stand as zero: read, and said."""

import numpy as np
import pytest

from ffgym.cli.main import main
from ffgym.robot.arm_file import read_arm

URDF = """<robot name="z">
<link name="base"/>
<link name="a"><inertial><mass value="3"/><origin xyz="0 0 0.2"/>
<inertia ixx="{}" iyy="{}" izz="{}" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="b"><inertial><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
</link>
<joint name="j1" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="50" velocity="2"/></joint>
<joint name="j2" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 0.4"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="50" velocity="2"/></joint>
</robot>
"""
BALL = 0.4 * 3 * 0.01**2


@pytest.mark.parametrize(
    ("said", "read"),
    [
        (("0.000", "0.0", "0"), (BALL, BALL, BALL)),
        (("0.01", "0.01", "0.000"), (0.01, 0.01, BALL)),
        (("0.001", "0.000", "0.000"), (0.001, 0.0005, 0.0005)),
    ],
)
def test_an_inertia_of_zero_is_the_least_that_a_body_has_and_is_said(said, read, tmp_path, capsys):
    path = tmp_path / "arm.urdf"
    path.write_text(URDF.format(*said), encoding="utf-8")
    arm = read_arm(path)
    np.testing.assert_allclose(arm.quantities["links.inertia"].value[0], [*read, 0, 0, 0], rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(arm.quantities["links.inertia"].value[1], [0.1, 0.1, 0.1, 0, 0, 0])
    assert [note for note in arm.notes if "the inertia of a is 0 about some axis" in note]
    assert main(["robot", "new", str(path), "--out", str(tmp_path / "arm.toml")]) == 0
    assert "note: the inertia of a is 0 about some axis" in capsys.readouterr().out


def test_inertias_that_are_given_stay_and_nothing_is_said(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(URDF.format("0.01", "0.02", "0.015"), encoding="utf-8")
    arm = read_arm(path)
    np.testing.assert_allclose(arm.quantities["links.inertia"].value[0], [0.01, 0.02, 0.015, 0, 0, 0], rtol=1e-9)
    assert not arm.notes
