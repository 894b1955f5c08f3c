"""The TCP of a serial arm by its chain of links, in elementwise arithmetic: far faster than the whole model."""

from dataclasses import dataclass

import mujoco
import numpy as np

from ffgym.core.types import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class ChainLink:
    """A body between the world and the TCP, in the frame of the body before it."""

    position: Array
    rotation: Array
    cross: Array | None = None
    """points @ cross is axis x points, for the unit axis of its hinge in the body's frame; None if it has none."""
    slide: Array | None = None
    """Unit axis of its sliding joint in the body's frame, shape (3,); None if it has none."""
    anchor: Array
    """Point on the hinge axis in the body's frame [m]."""
    joint: int = 0

    def place(self, points: Array, q: Array) -> Array:
        """Points (T, 3) of this body in the frame of the body before it, at joint positions `q` (T, N)."""
        if self.cross is not None:
            points = _rotate(points - self.anchor, self.cross, q[:, self.joint]) + self.anchor
        if self.slide is not None:
            points = points + q[:, [self.joint]] * self.slide
        return points @ self.rotation.T + self.position


def chain_to_site(model: mujoco.MjModel, site: int) -> tuple[ChainLink, ...]:
    """Bodies from the world to a site, the site last."""
    at_site = {"position": model.site_pos[site].copy(), "rotation": _matrix(model.site_quat[site])}
    chain = [ChainLink(**at_site, anchor=np.zeros(3))]
    body = int(model.site_bodyid[site])
    while body > 0:
        chain.append(_link_of(model, body))
        body = int(model.body_parentid[body])
    return tuple(reversed(chain))


def _link_of(model: mujoco.MjModel, body: int) -> ChainLink:
    joint = int(model.body_jntadr[body])
    slides = joint >= 0 and model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE
    return ChainLink(
        position=model.body_pos[body].copy(),
        rotation=_matrix(model.body_quat[body]),
        cross=np.cross(model.jnt_axis[joint], np.eye(3)) if joint >= 0 and not slides else None,
        slide=model.jnt_axis[joint].copy() if slides else None,
        anchor=model.jnt_pos[joint].copy() if joint >= 0 else np.zeros(3),
        joint=joint,
    )


def _matrix(quaternion: Array) -> Array:
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)


def _rotate(points: Array, cross: Array, angle: Array) -> Array:
    """Points (T, 3) turned by `angle` (T,) [rad] about the axis of `cross` (3, 3), Rodrigues' formula."""
    return (
        points + np.sin(angle)[:, None] * (points @ cross) + (1 - np.cos(angle))[:, None] * (points @ (cross @ cross))
    )
