"""Arm files for tests, the descriptions made from them, and the same files as MuJoCo itself reads them."""

import struct
from pathlib import Path

import mujoco
import numpy as np

from ffgym.robot import parse_robot
from ffgym.robot.arm_file import read_arm
from tests.robot.toml_entries import entry, small_motors

FILES = Path(__file__).parent / "files"

UR_JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
UR_JOINTS = [f"{name}_joint" for name in UR_JOINTS]

ARMS = {
    "ur_like.urdf": (None, "tool0"),
    "ur_like.xml": (UR_JOINTS, "attachment_site"),
    "kr_like.urdf": (None, "tool0"),
    "kr_like.xml": (None, "tip"),
    "seven_axes.xml": (None, "hand"),
    "scara.xml": (None, "tool0"),
}
"""Files with the joints that move (None is all) and a frame for the tool."""


def drive_table(types):
    """Everything that no arm file has, for joints of these types, as TOML."""

    def link(hinge, slide):
        units = [slide if kind == "slide" else hinge for kind in types]
        return units if len(set(units)) > 1 else units[0]

    n = len(types)
    numbers = [
        ("drive.gear_ratio", [100.0] * n, link("1", "rad/m")),
        ("drive.joint_stiffness", [2e4] * n, link("N m/rad", "N/m"), "link"),
        ("drive.joint_damping", [20.0] * n, link("N m s/rad", "N s/m"), "link"),
        ("servo.control_dt", 0.004, "s"),
        ("kinematics.max_speed", [3.0] * n, link("rad/s", "m/s"), "link"),
    ]
    return small_motors(n) + "".join(entry(*number) for number in numbers)


def description_text(model, types, *, more="", **head):
    """TOML of a description with an arm file."""
    lines = "".join(f"{key} = {value!r}\n" for key, value in head.items() if value is not None)
    return f"[robot]\nname = 'mine'\ntitle = 'My arm'\nmodel = {str(model)!r}\n{lines}{drive_table(types)}{more}"


def described(path, joints=None, frame=None, looks="none"):
    """Description of the arm in a file, with a tool without mass whose TCP is a named frame."""
    types = read_arm(path, joints, looks=False).types
    text = description_text(path.name, types, joints=joints, tool_frame=frame, looks=looks)
    return parse_robot(text, where="mine.toml", folder=path.parent)


def original(path):
    """The file as MuJoCo reads it: without shapes, and without what the drives put on the joints."""
    spec = mujoco.MjSpec.from_file(str(path))
    spec.compiler.fusestatic = False
    for texture in list(spec.textures):
        for material in spec.materials:
            material.textures = [""] * 10
        spec.delete(texture)
    for geom in list(spec.geoms):
        if geom.parent.explicitinertial or path.suffix == ".urdf":
            spec.delete(geom)
    for mesh in list(spec.meshes):
        spec.delete(mesh)
    model = spec.compile()
    model.dof_armature[:] = 0
    model.actuator_armature[:] = 0
    return model


class Original:
    """Kinematics and rigid dynamics of a file by MuJoCo's own functions, for some of its joints."""

    def __init__(self, path, joints):
        self.model = original(path)
        self.data = mujoco.MjData(self.model)
        names = [self.model.joint(j).name or f"joint{j + 1}" for j in range(self.model.njnt)]
        chosen = [names.index(name) for name in joints]
        self.positions, self.dofs = self.model.jnt_qposadr[chosen], self.model.jnt_dofadr[chosen]

    def pose(self, frame, q):
        """Position and orientation of a site, or else a body, in the world."""
        self.move(q, np.zeros(len(q)))
        sites = [self.model.site(i).name for i in range(self.model.nsite)]
        view = self.data.site(frame) if frame in sites else self.data.body(frame)
        return view.xpos, view.xmat.reshape(3, 3)

    def mass_matrix(self, q):
        """Shape (N, N), without drives."""
        self.move(q, np.zeros(len(q)))
        full = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, full)
        return full[np.ix_(self.dofs, self.dofs)]

    def bias(self, q, dq):
        """Gravity, Coriolis and centrifugal torque, shape (N,)."""
        self.move(q, dq)
        return self.data.qfrc_bias[self.dofs]

    def move(self, q, dq):
        """Put the chosen joints there; all others are at zero."""
        self.data.qpos[:] = 0
        self.data.qvel[:] = 0
        self.data.qpos[self.positions], self.data.qvel[self.dofs] = q, dq
        mujoco.mj_forward(self.model, self.data)


def write_stl(path, size=0.1):
    """A tetrahedron in a binary STL file."""
    corners = size * np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    triangles = [corners[[0, 2, 1]], corners[[0, 1, 3]], corners[[0, 3, 2]], corners[[1, 2, 3]]]
    records = [struct.pack("<12fH", 0, 0, 0, *triangle.ravel(), 0) for triangle in triangles]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(bytes(80) + struct.pack("<I", len(records)) + b"".join(records))
    return corners
