"""Measured quantities of the finished cam and their enclosure, from the path of the traced point.

A point p(θ) of the machine frame traces its curve on the turning cam. With D = d/dθ + J,
J (x, y) = (y, −x), the curve's tangent is T = D p and its second derivative is D T, both with
components in the machine frame. The geometry of every follower is measured by these formulas. None
of the closed forms that the optimiser has for it occurs here, so that an error in one cannot
confirm the other. Forces take pressure angle and curvature from the tangent and its turning; how a
load becomes a force, and a force a Hertz pressure, is the catalogue's, used by the optimiser too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, Final

import numpy as np

from synthesis.catalogue.followers.base import flat_face, paths, prime_radius
from synthesis.catalogue.followers.kinematics import Flank, TracePoint, Vector2
from synthesis.catalogue.forces.reduced import ContactState, face_pressure_square, pressure_square
from synthesis.catalogue.limits.base import Claim, Machine
from synthesis.catalogue.motion import Motion
from synthesis.certify.piecewise_motion import Jump, PiecewiseMotion
from synthesis.numerics.enclosure import Extremum, ExtremumQuery, enclose
from synthesis.numerics.piecewise import Array, Indices
from synthesis.numerics.taylor import Jets, Taylor

Size = tuple[float, ...]


@dataclass(frozen=True, eq=False)
class TracedPoint:
    """A traced point and its tangent at given s, s', s'', s''' (numbers, arrays or Taylor models).

    Terms that several quantities share are computed once. ``piece``: (n,) pieces of the motion that
    the n places lie on; ``process``: P there [N]; None where no force is measured.
    """

    trace: TracePoint
    size: Size
    s: tuple[Any, ...]
    piece: Indices | None = None
    process: Any = None

    @cached_property
    def position(self) -> tuple[Vector2, ...]:
        """p and its derivatives with respect to θ in the machine frame."""
        return self.trace.position(self.s, self.size)

    @cached_property
    def tangent(self) -> Vector2:
        """T = D p."""
        (px, py), (dx, dy), *_ = self.position
        return dx + py, dy - px

    @cached_property
    def moment(self) -> Any:
        """(n · p) |T|, n the unit normal of the curve: the moment of T about the cam's axis."""
        (px, py), *_ = self.position
        tx, ty = self.tangent
        return py * tx - px * ty

    @cached_property
    def tangent_squared(self) -> Any:
        """|T|²."""
        tx, ty = self.tangent
        return tx * tx + ty * ty

    @cached_property
    def tangent_length(self) -> Any:
        """|T|."""
        return np.sqrt(self.tangent_squared)


Formula = Callable[[TracedPoint], Any]


def pressure_angle(at: TracedPoint) -> Any:
    """α from the outward normal of the profile to the direction g in which the cam drives [rad]."""
    nx, ny = at.trace.normal(at.tangent, at.s, at.size)
    (gx, gy), _ = at.trace.drive_direction(at.s, at.size)
    return np.arctan2(gx * ny - gy * nx, gx * nx + gy * ny)


def pitch_curvature(at: TracedPoint) -> Any:
    """κ = T × D T / |T|³ of the traced curve, which runs clockwise: convex positive [1/mm]."""
    _, (dx, dy), (ax, ay), *_ = at.position
    tx, ty = at.tangent
    # D T = T' + J T, so that T × D T = T × T' + |T|²
    return (at.tangent_squared + ty * (ax + dy) - tx * (ay - dx)) / (
        at.tangent_squared * at.tangent_length
    )


def pitch_radius(at: TracedPoint) -> Any:
    """|p|, the distance of the traced curve from the cam's axis [mm]."""
    (px, py), *_ = at.position
    return np.hypot(px, py)


def face_radius(at: TracedPoint) -> Any:
    """Signed radius of the profile under a flat face, ρ = T·m / m·m with m = n' + J n [mm].

    n is the face's unit normal at the contact point. The profile is the envelope of the face, so
    that ρ is negative where T runs against the turning of the face, which is undercut, and passes
    through 0 at a cusp. The curvature from T alone would lose the sign.
    """
    tx, ty = at.tangent
    face = flat_face(at.trace)
    assert face is not None
    mx, my = face.face_normal_rate(at.s, at.size)
    return (tx * mx + ty * my) / (mx * mx + my * my)


def contact(at: TracedPoint) -> Any:
    """Position of the contact point along the face, from the face's reference point [mm]."""
    (px, py), *_ = at.position
    face = flat_face(at.trace)
    assert face is not None
    (mx, my), (ax, ay) = face.face_axis(at.s, at.size)
    return (px - mx) * ax + (py - my) * ay


def _derivative(order: int) -> Formula:
    return lambda at: at.s[order]


@dataclass(frozen=True)
class Quantity:
    """A function of the cam angle that can be enclosed.

    Attributes:
        formula: its value at a traced point, of numbers or of Taylor models.
        order: highest derivative of s that it uses.
        continuous_below: if a derivative of s below this order jumps, it is infinite there.
        absolute_width: width of an enclosure that suffices, besides 1e-10 of the value.
        width_per_size: the same as a share of the cam's size, for lengths that may vanish.
        infinite_at_corners: whether a corner of the traced curve makes it infinite, with the sign
            of the corner.
        loaded: whether it needs the process force.
    """

    formula: Formula
    order: int
    continuous_below: int = 0
    absolute_width: float = 0.0
    width_per_size: float = 0.0
    infinite_at_corners: bool = False
    loaded: bool = False


# Widths: 1e-10 rad of a pressure angle is 6e-9°; the shares of the cam's size are a hundred times
# the rounding errors of a radius or a contact position, and the rounding error itself of travel.
QUANTITIES = {
    "travel": Quantity(_derivative(0), 0, width_per_size=1e-14),
    "displacement": Quantity(_derivative(0), 0),
    "velocity": Quantity(_derivative(1), 1, 1),
    "acceleration": Quantity(_derivative(2), 2, 2),
    "jerk": Quantity(_derivative(3), 3, 3),
    "pressure_angle": Quantity(pressure_angle, 1, absolute_width=1e-10),
    "pitch_curvature": Quantity(pitch_curvature, 2, infinite_at_corners=True),
    "pitch_radius": Quantity(pitch_radius, 1),
    "face_radius": Quantity(face_radius, 2, 2, width_per_size=1e-12),
    "contact": Quantity(contact, 1, 1, width_per_size=1e-12),
    "contact_left": Quantity(lambda at: -contact(at), 1, 1, width_per_size=1e-12),
    "contact_right": Quantity(contact, 1, 1, width_per_size=1e-12),
}


def tangent_clearance(depth: float) -> Quantity:
    """(n · p − depth) |T|: positive where the tangent passes the axis at more than ``depth`` [mm].

    The axis lies on the inner side of the curve there.
    """
    return Quantity(lambda at: at.moment - depth * at.tangent_length, 1)


Subject = tuple[Quantity, str]  # a quantity, and the name of the traced curve it is measured on
# bounds of a question for the largest value, by side 1, and for the smallest, by side −1
BOUNDS: Final = {1: (-math.inf, 0.0), -1: (0.0, math.inf)}


@dataclass(frozen=True, eq=False)
class MeasuredCam:
    """A finished cam: its motion in pieces, its machine, and the follower's size [mm]."""

    motion: PiecewiseMotion
    machine: Machine
    size: Size

    @classmethod
    def of(cls, motion: Motion, machine: Machine, size: Size) -> MeasuredCam:
        """The motion is cut where the process force bends or jumps: P is linear on each piece."""
        cuts = () if machine.load is None else tuple(machine.load.process.breaks[1:-1].tolist())
        return cls(_pieces(motion, cuts), machine, tuple(float(z) for z in size))

    @cached_property
    def traces(self) -> Mapping[str, TracePoint]:
        """The traced curves by name; "" is the first of them."""
        named = paths(self.machine.follower)
        return {"": next(iter(named.values())), **named}

    @cached_property
    def _process(self) -> tuple[Jets, Indices]:
        """The process force, and the index of its piece over each piece of the motion."""
        assert self.machine.load is not None
        breaks, process = self.motion.curve.breaks, self.machine.load.process
        return Jets(process), process.piece_of(0.5 * (breaks[1:] + breaks[:-1]))

    def _evaluate(
        self, subjects: Sequence[Subject], s: tuple[Any, ...], piece: Indices, process: Any
    ) -> list[Any]:
        points = {
            path: TracedPoint(self.traces[path], self.size, s, piece, process)
            for _, path in subjects
        }
        return [quantity.formula(points[path]) for quantity, path in subjects]

    def models(
        self, subjects: Sequence[Subject], piece: Indices, lo: Array, hi: Array
    ) -> list[Taylor]:
        """Taylor models of quantities on boxes [lo, hi] of pieces (n,) [rad]."""
        highest, process = max(quantity.order for quantity, _ in subjects), None
        s, *rates = self.motion.jets.models(piece, lo, hi, highest)
        if any(quantity.loaded for quantity, _ in subjects):
            force, owner = self._process
            (process,) = force.models(owner[piece], lo, hi, 0)
        found = self._evaluate(subjects, (s, *rates, *(3 - highest) * (0.0,)), piece, process)
        return [each if isinstance(each, Taylor) else s.constant(each) for each in found]

    def values(self, subjects: Sequence[Subject], piece: Indices, x: Array) -> list[Array]:
        """Values (n,) of quantities at cam angles x (n,) of pieces [rad]."""
        process = None
        if any(quantity.loaded for quantity, _ in subjects):
            force, owner = self._process
            process = force.curve.at(x, owner[piece], 0)
        return self._evaluate(subjects, tuple(self.motion.curve.jet(x, piece, 3)), piece, process)

    def sides(self, path: str, junction: int) -> list[TracedPoint]:
        """The traced point on the left and on the right of a junction."""
        both = self.motion.one_sided_values(junction)
        return [TracedPoint(self.traces[path], self.size, s) for s in both]

    def turning_at(self, path: str, junction: int) -> float:
        """Cross product of the traced curve's tangents at a junction: convex corners positive."""
        before, after = (point.tangent for point in self.sides(path, junction))
        return float(before[1] * after[0] - before[0] * after[1])

    def extreme(
        self, subject: Subject, segments: Sequence[int], bounds: tuple[float, float]
    ) -> Extremum:
        """The extreme of one quantity on segments that is nearest to its bounds."""
        return self.enclose([subject], [ExtremumQuery(self.motion.pieces_of(segments), *bounds)])[0]

    def enclose(
        self, subjects: Sequence[Subject], questions: Sequence[ExtremumQuery]
    ) -> list[Extremum]:
        """Enclose extremes of quantities over the cam angle, one-sided at junctions.

        The width that suffices is the larger of the question's own and the quantity's.
        """
        scale = prime_radius(self.machine.follower, self.size)
        return enclose(
            lambda piece, lo, hi, wanted: self.models([subjects[k] for k in wanted], piece, lo, hi),
            self.motion.curve.breaks,
            self.motion.initial_boxes,
            questions,
            lambda piece, x, wanted: self.values([subjects[k] for k in wanted], piece, x),
            [quantity.absolute_width + quantity.width_per_size * scale for quantity, _ in subjects],
        )


@lru_cache(maxsize=4)
def _pieces(motion: Motion, cuts: tuple[float, ...]) -> PiecewiseMotion:
    """Certificate, objectives, forces and summary of one motion share its tables."""
    return PiecewiseMotion(motion, cuts)


def infinite_by_jump(
    quantity: Quantity,
    motion: PiecewiseMotion,
    segments: Sequence[int],
    part: tuple[float, float] | None = None,
) -> Jump | None:
    """The jump of s, s', … of lowest order that makes the quantity infinite on these segments."""
    if motion.is_continuous_below(quantity.continuous_below):
        return None  # the others are not asked for: this is much cheaper
    junctions = motion.junctions_of(segments, part)
    for order in range(quantity.continuous_below):
        jumps = motion.discontinuities(order, junctions)
        if len(jumps):
            return motion.largest_jump(order, jumps)
    return None


def infinite_at_corner(quantity: Quantity, cam: MeasuredCam, claim: Claim) -> Jump | None:
    """A jump of the velocity at which the traced curve has a corner of the sense the claim bounds.

    At a corner the curvature is +∞ or −∞, by the sense in which the tangent turns there. A claim
    with an upper bound excludes the first, one with a lower bound the second.
    """
    motion = cam.motion
    if not quantity.infinite_at_corners or motion.is_continuous_below(2):
        return None
    for junction in motion.discontinuities(1, motion.junctions_of(claim.segments, claim.interval)):
        turn = cam.turning_at(claim.path, int(junction))
        if (turn > 0.0 and claim.upper is not None) or (turn < 0.0 and claim.lower is not None):
            return motion.largest_jump(1, np.array([junction]))
    return None


WITHOUT_CURVATURE: Final[Mapping[str, Callable[[ContactState], Any]]] = {
    "drive_force": ContactState.drive,
    "contact_force": ContactState.contact_force,
    "camshaft_torque": ContactState.torque,
}
FORCES: Final = (*WITHOUT_CURVATURE, "pressure_square")
NEGLIGIBLE: Final = 1e-11  # width of an enclosure that suffices, as a share of the largest sample
SAMPLES: Final = (0.02, 0.5, 0.98)  # places on each piece where those samples are taken


def quantity_of(name: str, flank: str, cam: MeasuredCam) -> Quantity:
    """The quantity of this name; a force is that on the named flank, or on the first one."""
    if name not in FORCES:
        return QUANTITIES[name]
    flanks = cam.machine.follower.flanks
    return force_quantity(name, next((f for f in flanks if f.name == flank), flanks[0]), cam)


def force_quantity(name: str, flank: Flank, cam: MeasuredCam) -> Quantity:
    """A force, the torque, or the square of the pressure on a flank, by equilibrium."""
    load, segments = cam.machine.load, cam.motion.segments
    assert load is not None
    # sense in which friction acts on each piece: against the sliding of the follower in its guide
    sliding = np.array([load.sliding_sense(s) for s in segments])[cam.motion.segment_of_piece]

    def formula(at: TracedPoint) -> Any:
        if at.trace is not flank.trace:  # on this flank's path, whichever the subject names
            at = replace(at, trace=flank.trace)
        # sine and cosine of the pressure angle, from the normal and the direction of drive
        nx, ny = at.trace.normal(at.tangent, at.s, at.size)
        (gx, gy), _ = at.trace.drive_direction(at.s, at.size)
        length = np.sqrt(nx * nx + ny * ny)
        place = ContactState(
            load, cam.machine.omega, at.s, at.process, sliding[at.piece],
            (gx * ny - gy * nx) / length, (gx * nx + gy * ny) / length,
            at.trace.lever(at.s, at.size),
        )  # fmt: skip
        if name != "pressure_square":
            return WITHOUT_CURVATURE[name](place)
        force = place.contact_force()
        if cam.machine.follower.always_convex:
            return face_pressure_square(load, force, face_radius(at))
        return pressure_square(load, flank, force, pitch_curvature(at))

    corners = name == "pressure_square"  # infinite there, as the curvature is
    quantity = Quantity(formula, 2, 2, infinite_at_corners=corners, loaded=True)
    # a force may vanish where its bound is 0: the width that suffices is a share of its samples
    curve = cam.motion.curve
    x = (curve.breaks[:-1, None] + np.diff(curve.breaks)[:, None] * SAMPLES).ravel()
    piece = np.arange(curve.count).repeat(len(SAMPLES))
    with np.errstate(all="ignore"):
        (values,) = cam.values([(quantity, flank.path)], piece, x)
    size = float(np.max(np.abs(values)[np.isfinite(values)], initial=0.0))
    return replace(quantity, absolute_width=NEGLIGIBLE * size)
