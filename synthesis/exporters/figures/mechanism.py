"""The machine in motion: where link, contacts and rollers stand over one turn of the cam.

All in the machine's frame of a ccw cam; a clockwise one is its mirror image. A roller's centre
moves on the cam with the speed w = |D p| per radian along its clockwise curve. Where it rolls, its
point at the contact rests on the cam, Rr away, so it turns by −σ w/Rr against the cam, and by

    Ω = 1 − σ w/Rr

in the machine; on the profile the contact runs w (1 − σκ Rr), on the roller as far.
"""

from __future__ import annotations

import cmath
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from synthesis.catalogue.followers.base import flat_face
from synthesis.catalogue.followers.kinematics import Face, Flank, Link, Vector2
from synthesis.catalogue.profile import CamProfile
from synthesis.exporters.samples.cam import Cam
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

NODES, WEIGHTS = np.polynomial.legendre.leggauss(5)


@dataclass(frozen=True, eq=False)
class Contact:
    """Where the follower touches one traced curve's flank; angles [rad] as seen from its link.

    Attributes:
        flank: the flank; of a groove the inner one. curve: the cam there, (n,).
        place: roller's centre, or the point of the face that reach is measured from, on the link
            at displacement 0 [mm].
        roller: its radius [mm], and heading: direction of a face; 0 without one.
        along: (n,) how far along the face the contact is [mm]; 0 without a face.
        normal: (n,) direction of the common normal, away from the cam.
        drive: (n,) direction in which the follower is driven.
        roll: (n,) angle that the roller has turned through since cam angle 0.
    """

    flank: Flank
    curve: CamProfile
    place: complex
    roller: float
    heading: float
    along: Array
    normal: Array
    drive: Array
    roll: Array


@dataclass(frozen=True, eq=False)
class Mechanism:
    """A cam and its follower over one turn.

    Attributes:
        theta: (n,) cam angles from 0 to 2π, both included [rad].
        s: (n,) displacement in the unit of travel.
        slide: unit vector along which the link moves; None where it turns.
        pivot: about which it turns [mm]; None where it slides. face: it has, if any.
        moved: (n,) by how much it moves: along its slide [mm], or ccw at its pivot [rad].
        contacts: one for each traced curve.
    """

    theta: Array
    s: Array
    slide: complex | None
    pivot: complex | None
    face: Face | None
    moved: Array
    contacts: tuple[Contact, ...]

    @classmethod
    def of(cls, cam: Cam, count: int, by: float = 1.0) -> Mechanism:
        """The machine at ``count`` + 1 evenly spaced cam angles.

        ``by``: how many times its size it is drawn; motion and cam that are shown stay.
        """
        theta = np.linspace(0.0, FULL_TURN, count + 1)
        s = cam.motion.derivatives(theta, 3)
        shown, link = s[0] / cam.travel.per_unit, cam.follower.link(cam.size, DEGREE)
        slide, pivot = (v if v is None else _point(v) for v in (link.slide, link.pivot))
        moved = link.turn * shown * DEGREE if slide is None else by * s[0]
        pivot = pivot if pivot is None else by * pivot
        machine = cls(theta, shown, slide, pivot, link.face, moved, ())
        firsts = {one.flank.path: one for one in reversed(tuple(cam.flanks()))}
        contacts = (_contact(firsts[path], machine, link, s, by) for path in reversed(firsts))
        return replace(machine, contacts=tuple(contacts))

    def carried(self, points: Any, moved: Any) -> Any:
        """Points of the link at displacement 0, moved with it (by some of ``moved``)."""
        if self.slide is not None:
            return points + moved * self.slide
        return self.pivot + (np.cos(moved) + 1j * np.sin(moved)) * (points - self.pivot)


def _point(vector: Vector2) -> complex:
    return complex(float(vector[0]), float(vector[1]))


def _contact(cam: Cam, machine: Mechanism, link: Link, s: Array, by: float) -> Contact:
    theta, trace, flank, first = machine.theta, cam.flank.trace, cam.flank, cam.follower.flanks[0]
    turned = machine.moved if machine.slide is None else 0.0 * theta
    p, tangent = _traced(cam, s)
    normal, (drive, _) = trace.normal(tangent, s, cam.size), trace.drive_direction(s, cam.size)
    roller = cam.follower.roller_radius_mm if flank.path == first.path else flank.distance
    along, roll, heading = 0.0 * theta, 0.0 * theta, 0.0
    if link.face is not None:
        place, direction = by * _point(link.face.at), _point(link.face.along)
        there = machine.carried(by * (p[0] + 1j * p[1]), -machine.moved)
        along, heading = ((there - place) / direction).real, cmath.phase(direction)
    else:
        place = by * _point(next(tip.at for tip in link.tips if tip.path == flank.path))
    if roller > 0.0:
        roll = theta - flank.side * _travelled(cam, theta) / roller - (turned - turned[0])
    normal_angle, drive_angle = (
        np.unwrap(np.arctan2(y, x) + 0.0 * theta) - turned for x, y in (normal, drive)
    )
    return Contact(
        flank.scaled(by), cam.at(theta), place, by * roller, heading, along, normal_angle,
        drive_angle, roll,
    )  # fmt: skip


def _traced(cam: Cam, s: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """The traced point and D of it in the machine's frame [mm]."""
    (px, py), (dx, dy), *_ = cam.flank.trace.position(s, cam.size)
    return (px, py), (dx + py, dy - px)


def _travelled(cam: Cam, theta: Array) -> Array:
    """Way of the roller's centre on the cam since the first angle, ∫ w dθ [mm], (n,)."""
    marks = np.union1d(theta, cam.joints.marked(3))
    half = 0.5 * np.diff(marks)
    at = marks[:-1, None] + half[:, None] * (1.0 + NODES)
    _, (tx, ty) = _traced(cam, cam.motion.derivatives(at.ravel(), 3))
    w = np.hypot(tx, ty).reshape(at.shape)
    way = np.concatenate([[0.0], np.cumsum(half * (w @ WEIGHTS))])
    return way[np.searchsorted(marks, theta)]


def face_at_rest(cam: Cam, machine: Mechanism) -> tuple[tuple[float, float], complex]:
    """How far a face reaches to the left and the right [mm], and its direction to the right.

    At cam angle 0, as someone behind it sees it; (0, 0) without a face.
    """
    face, kind = machine.face, flat_face(cam.follower)
    if face is None or kind is None:
        return (0.0, 0.0), 1.0 + 0.0j
    turn = cmath.rect(1.0, 0.0 if machine.pivot is None else machine.moved[0])
    normal, axis = (turn * _point(each) for each in (face.normal, face.along))
    reach = cam.follower.motion_dimensions(cam.motion, cam.size)
    first, second = (reach[f"face_{end}_mm"] for end in kind.face_ends)
    if machine.pivot is not None:  # both are measured from the foot of the pivot
        first = -first
    along = -1j * normal
    forward = (axis.conjugate() * along).real > 0.0
    return (first, second) if forward else (second, first), along
