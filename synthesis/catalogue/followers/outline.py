"""The end of the follower that meets the cam, as a drawing shows it at cam angle 0."""

from __future__ import annotations

import math
from dataclasses import dataclass

from synthesis.catalogue.constraints import Vector
from synthesis.catalogue.followers.base import Follower, flat_face
from synthesis.catalogue.motion import Motion

Point = tuple[float, float]


@dataclass(frozen=True)
class FollowerOutline:
    """In the machine frame of a ccw cam [mm].

    Attributes:
        centre: where the stem begins. roller: radius about it, 0 where there is no roller.
        left, right: reach of a face from there to either side, both 0 where there is none.
        along: unit vector along the face, to the right.
        pivot: of an arm, None where the follower slides.
    """

    centre: Point
    roller: float
    left: float = 0.0
    right: float = 0.0
    along: Point = (1.0, 0.0)
    pivot: Point | None = None


def follower_outline(follower: Follower, motion: Motion, z: Vector) -> FollowerOutline:
    """The follower at cam angle 0, from its link moved by the displacement there.

    Args:
        motion, z: the finished cam.
    """
    s = motion.derivatives([0.0])[:, 0].tolist()
    link = follower.link(z, math.pi / 180.0)
    pivot = None if link.pivot is None else _floats(link.pivot)
    face = flat_face(follower)
    if face is None:
        (x, y), *_ = follower.position(s, z)
        return FollowerOutline((float(x), float(y)), follower.roller_radius, pivot=pivot)
    # The face has turned about its pivot, or has been lifted along the slide.
    (x, y), axis = face.face_axis(s, z)
    nx, ny = _floats(face.normal((0.0, 0.0), s, z))
    if pivot is not None and link.face is not None:
        # From the foot of the pivot on the face, at the offset of the face from the pivot.
        (ax, ay), (bx, by) = link.face.at, link.face.normal
        offset = float((ax - pivot[0]) * bx + (ay - pivot[1]) * by)
        x, y = x + offset * nx, y + offset * ny
    along = ny, -nx
    # Reach counts along the face's axis; left and right are those of someone behind the face.
    reach = follower.motion_dimensions(motion, z)
    first, second = (reach[f"face_{end}_mm"] for end in face.face_ends)
    if pivot is not None:
        first = -first
    forward = along[0] * axis[0] + along[1] * axis[1] > 0.0
    left, right = (first, second) if forward else (second, first)
    return FollowerOutline((float(x), float(y)), 0.0, left, right, along, pivot)


def _floats(point: tuple[object, object]) -> Point:
    x, y = point
    return float(x), float(y)  # type: ignore[arg-type]
