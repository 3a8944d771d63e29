"""The follower's output link as a bare mechanism: what carries it, and what of it meets the cam.

Positions at displacement 0 and nothing else: velocities, normals and curvatures are derived by
the reader, so that they can be derived a second time without a formula of the family's own.
"""

from __future__ import annotations

from dataclasses import dataclass

from synthesis.catalogue.followers.kinematics import Vector2


@dataclass(frozen=True)
class Tip:
    """A roller's centre or a knife edge on the link.

    Attributes:
        path: name of the curve that it traces. at: its place.
        outward: +1 where its cam drives the link the way displacement grows, −1 the other way.
    """

    path: str
    at: Vector2
    outward: int = 1


@dataclass(frozen=True)
class Face:
    """A flat face on the link.

    Attributes:
        at: a point of it, from which its reach is measured.
        along: unit vector in the sense of positive reach. normal: unit vector away from the cam.
    """

    at: Vector2
    along: Vector2
    normal: Vector2


@dataclass(frozen=True)
class Link:
    """The output link at displacement 0, in the machine frame of a ccw cam [mm].

    Attributes:
        slide: unit vector along which it moves by s [mm]; None where it turns.
        pivot: about which it turns by φ [rad]; None where it slides.
        turn: +1 where it turns counter-clockwise as φ grows, −1 where clockwise.
        tips, face: what meets the cam.
    """

    tips: tuple[Tip, ...] = ()
    face: Face | None = None
    slide: Vector2 | None = None
    pivot: Vector2 | None = None
    turn: int = 1
