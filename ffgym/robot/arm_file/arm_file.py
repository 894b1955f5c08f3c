"""Content of an arm file: numbers of a description, named frames, looks, and hints about the drives."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import mujoco

from ffgym.core.errors import check_choice
from ffgym.core.types import Array
from ffgym.robot.parts import Geom
from ffgym.robot.reading.quantity import Quantity


@dataclass(frozen=True, kw_only=True, eq=False)
class Source:
    """Common form of both formats."""

    spec: mujoco.MjSpec
    """Bodies, joints, masses and geoms, ready to be compiled."""
    speeds: Mapping[str, float] = field(default_factory=dict)
    """Speed limits of joints [rad/s] or [m/s]."""
    gear_ratios: Mapping[str, float] = field(default_factory=dict)
    """Motor over joint motion, of joints."""
    has_masses: bool = True
    """True if it gives masses of links; if not, the model's masses are stand-ins without meaning."""
    notes: tuple[str, ...] = ()
    """Parts of the file that are left out."""


Kind = Literal["mjcf", "urdf"]


@dataclass(frozen=True, kw_only=True, eq=False)
class NamedFrame:
    """A site, body or URDF link that is part of the last link, e.g. tool0, in the frame of that link."""

    position: Array
    """Origin [m], shape (3,)."""
    rotation: Array
    """Orientation, shape (3, 3)."""


@dataclass(frozen=True, kw_only=True)
class JointHints:
    """Hints of the file about the drive of a joint, link side; None for numbers that it lacks.

    Units are those of a hinge; a sliding joint has m for rad, and N for N m.
    """

    effort: float | None = None
    """Largest torque [N m]."""
    speed: float | None = None
    """Largest speed [rad/s]."""
    damping: float | None = None
    """Viscous friction [N m s/rad]."""
    friction: float | None = None
    """Coulomb friction [N m]."""
    armature: float | None = None
    """Rotor inertia as the joint feels it, n^2 J_m [kg m^2]."""
    gear_ratio: float | None = None
    """Motor over joint motion n."""
    position_gain: float | None = None
    """Gain of a position servo in the file [N m/rad]."""
    velocity_gain: float | None = None
    """Gain of a position or velocity servo in the file [N m s/rad]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ArmFile:
    """An arm as its file describes it; at q = 0 all link frames are parallel to the world."""

    path: str
    """Path of the file, as the caller gave it."""
    kind: Kind
    """Its format."""
    joints: tuple[str, ...]
    """Joints that move, from the base outwards."""
    links: tuple[str, ...]
    """The body behind each joint."""
    types: tuple[str, ...]
    """'hinge' or 'slide', one per joint."""
    quantities: Mapping[str, Quantity]
    """Entries of a robot description, by their path; `kinematics.range` and `kinematics.max_speed` only if the file
    gives them for every joint."""
    frames: Mapping[str, NamedFrame]
    """Frames of the last link by name."""
    hints: tuple[JointHints, ...]
    """Hints, one per joint."""
    geoms: tuple[Geom, ...]
    """Looks; empty unless requested."""
    notes: tuple[str, ...]
    """Notes on content that a description leaves out, and warnings of MuJoCo; one sentence each."""

    def frame(self, name: str) -> NamedFrame:
        """Frame of the last link by its name.

        Raises:
            FFGymError: if there is none; the message lists what there is.
        """
        return self.frames[check_choice(f"frame on {self.links[-1]!r} in {self.path}", name, list(self.frames))]
