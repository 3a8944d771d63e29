"""The machine in motion: where link, contacts and rollers stand over one turn of the cam.

All in the machine's frame of a ccw cam; a clockwise one is its mirror image. A roller's centre
moves on the cam with the speed w = |D p| per radian along its clockwise curve. Where it rolls, its
point at the contact rests on the cam, Rr away, so it turns by −σ w/Rr against the cam, and by

    Ω = 1 − σ w/Rr

in the machine; on the profile the contact runs w (1 − σκ Rr), on the roller as far.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

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
        roller: its radius, 0 without one [mm].
        heading: direction of a face, 0 without one.
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
    def of(cls, cam: Cam, count: int) -> Mechanism:
        """The machine at ``count`` + 1 evenly spaced cam angles."""
        theta = np.linspace(0.0, FULL_TURN, count + 1)
        s = cam.motion.derivatives(theta, 3)
        shown, link = s[0] / cam.travel.per_unit, cam.follower.link(cam.size, DEGREE)
        swings = link.slide is None
        moved = link.turn * shown * DEGREE if swings else s[0]
        turned = moved if swings else 0.0 * moved
        firsts = {one.flank.path: one for one in reversed(tuple(cam.flanks()))}
        contacts = [
            _contact(firsts[path], link, theta, (s, moved, turned)) for path in reversed(firsts)
        ]
        slide, pivot = (v if v is None else _point(v) for v in (link.slide, link.pivot))
        return cls(theta, shown, slide, pivot, link.face, moved, tuple(contacts))

    def magnified(self, by: float) -> Mechanism:
        """The same machine with all lengths so many times as large; what is shown of it stays."""
        contacts = tuple(
            replace(
                each,
                flank=each.flank.scaled(by),
                place=by * each.place,
                roller=by * each.roller,
                along=by * each.along,
            )
            for each in self.contacts
        )
        moved = self.moved if self.slide is None else by * self.moved
        pivot = None if self.pivot is None else by * self.pivot
        return replace(self, pivot=pivot, moved=moved, contacts=contacts)


def _point(vector: Vector2) -> complex:
    return complex(float(vector[0]), float(vector[1]))


def _contact(cam: Cam, link: Link, theta: Array, state: tuple[Array, Array, Array]) -> Contact:
    s, moved, turned = state
    trace, flank, first = cam.flank.trace, cam.flank, cam.follower.flanks[0]
    p, tangent = _traced(cam, s)
    nx, ny = trace.normal(tangent, s, cam.size)
    (gx, gy), _ = trace.drive_direction(s, cam.size)
    roller = cam.follower.roller_radius if flank.path == first.path else flank.distance
    along, roll, heading = np.zeros_like(theta), np.zeros_like(theta), 0.0
    if link.face is not None:
        at, (ux, uy) = link.face.at, link.face.along
        along, heading = _reached(link, link.face, p, moved), float(np.arctan2(uy, ux))
    else:
        at = next(tip.at for tip in link.tips if tip.path == flank.path)
    if roller > 0.0:
        roll = theta - flank.side * _travelled(cam, theta) / roller - (turned - turned[0])
    return Contact(
        flank=flank,
        curve=cam.at(theta),
        place=_point(at),
        roller=roller,
        heading=heading,
        along=along,
        normal=np.unwrap(np.arctan2(ny, nx) + 0.0 * theta) - turned,
        drive=np.unwrap(np.arctan2(gy, gx) + 0.0 * theta) - turned,
        roll=roll,
    )


def _traced(cam: Cam, s: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """The traced point and D of it in the machine's frame [mm]."""
    (px, py), (dx, dy), *_ = cam.flank.trace.position(s, cam.size)
    return (px, py), (dx + py, dy - px)


def _reached(link: Link, face: Face, p: tuple[Array, Array], moved: Array) -> Array:
    """How far along a face, from where its reach is measured, points of the machine are (n,)."""
    x, y = p
    if link.slide is not None:
        x, y = x - moved * link.slide[0], y - moved * link.slide[1]
    if link.pivot is not None:
        cos, sin = np.cos(moved), np.sin(moved)
        x, y = x - link.pivot[0], y - link.pivot[1]
        x, y = link.pivot[0] + cos * x + sin * y, link.pivot[1] + cos * y - sin * x
    return np.asarray((x - face.at[0]) * face.along[0] + (y - face.at[1]) * face.along[1])


def _travelled(cam: Cam, theta: Array) -> Array:
    """Way of the roller's centre on the cam since the first angle, ∫ w dθ [mm], (n,)."""
    marks = np.union1d(theta, cam.joints.marked(3))
    half = 0.5 * np.diff(marks)
    at = marks[:-1, None] + half[:, None] * (1.0 + NODES)
    _, (tx, ty) = _traced(cam, cam.motion.derivatives(at.ravel(), 3))
    w = np.hypot(tx, ty).reshape(at.shape)
    way = np.concatenate([[0.0], np.cumsum(half * (w @ WEIGHTS))])
    return way[np.searchsorted(marks, theta)]
