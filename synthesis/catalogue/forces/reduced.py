"""The load reduced to the follower's displacement s: what the drive G is made of.

    G(θ) = m s'' ω² + c s' ω + k s + σ F0 + W + P(θ)

σ is +1 where the spring presses the follower towards the cam's axis and −1 in a ring, where it
presses it outwards; there its force falls as s grows, F0 − k s, and k keeps its sign in G. On a cam
with two flanks or a counter cam it presses inwards.

``history`` has the course of all forces over the turn, from the follower's closed forms. The
certificate takes its geometry from the traced path instead; a test holds the two together.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from synthesis.catalogue.followers import Follower
from synthesis.catalogue.followers.kinematics import Flank, pressure_angle_sine_cosine
from synthesis.catalogue.forces.friction import FrictionModel
from synthesis.catalogue.forces.load_parts import Contact, RollerBearing
from synthesis.catalogue.motion import Motion, PlacedSegment, within_turn
from synthesis.numerics.piecewise import Array, Piecewise, Side
from synthesis.units import FULL_TURN

MILLI: Final = 1e-3  # metres in a millimetre
NEAR_END: Final = 1e-12  # rad: an angle this near to a segment's end is its end, but for rounding
BESIDE: Final = 1e-9  # rad: how far beside a jump its two sides are looked at
SENSES: Final = {"rise": 1.0, "dwell": 0.0, "return": -1.0, "table": 0.0}


@dataclass(frozen=True, eq=False)
class ReducedLoad:
    """The load on the follower, reduced to its displacement; N, mm, kg, s.

    Attributes:
        mass: m [kg]. damping: c [N s/m]. rate: k [N/mm]. preload: F0 [N].
        side: σ. weight: W [N]. process: P over the turn [N over rad].
        friction: of a slide's guide.
        contact, bearing: of the line contact and the roller; None where not given.
        speeds: least and largest speed of the cam at which it must not float [rad/s].
        pushed_both_ways: inwards as well as outwards.
    """

    mass: float
    damping: float
    rate: float
    preload: float
    side: int
    weight: float
    process: Piecewise
    friction: FrictionModel | None
    contact: Contact | None
    bearing: RollerBearing | None
    speeds: tuple[float, float]
    pushed_both_ways: bool

    @property
    def constant_force(self) -> float:
        """The part of G that depends on neither the motion nor the cam angle [N]."""
        return self.side * self.preload + self.weight

    def coefficients(self, omega: float) -> tuple[float, float, float, float]:
        """Factors of s to s''' in G at a cam speed [rad/s]: N over mm per rad^k."""
        mass = self.mass * omega * omega * MILLI
        return self.rate, self.damping * omega * MILLI, mass, 0.0

    def drive(self, s: Any, process: Any, omega: float) -> Any:
        """G [N] from s to s'' and the process force, of any arithmetic type."""
        a, b, c, _ = self.coefficients(omega)
        return s[0] * a + s[1] * b + s[2] * c + (process + self.constant_force)

    def process_on(self, segment: PlacedSegment, theta: Array) -> Array:
        """P at cam angles of a segment [N]; of a jump at its end, the value before it."""
        inside = np.clip(theta, segment.start, min(segment.end, FULL_TURN))
        ends = inside >= segment.end - NEAR_END
        return np.where(ends, self.process(inside, 0, "left"), self.process(inside))

    def split_at_jumps(self, segment: PlacedSegment) -> PlacedSegment:
        """The segment with pieces of its law that end just before and just after a jump of P."""
        inner = self._breaks_inside(segment)
        jumps = inner[self.process(inner) != self.process(inner, 0, "left")]
        if segment.law is None or not len(jumps):
            return segment
        beside = np.concatenate([jumps - BESIDE, jumps + BESIDE])
        law, _ = segment.law.split_at((beside - segment.start) / segment.angle)
        return segment.with_law(law)

    def _breaks_inside(self, segment: PlacedSegment) -> Array:
        breaks = self.process.breaks
        return breaks[(breaks > segment.start) & (breaks < segment.end)]

    def process_range(self, segment: PlacedSegment) -> tuple[float, float]:
        """Least and largest process force on a segment [N]: straight pieces have them at ends."""
        ends = np.array([segment.start, *self._breaks_inside(segment), segment.end])
        each = np.concatenate([self.process(ends[:-1]), self.process(ends[1:], 0, "left")])
        return float(each.min()), float(each.max())

    def sliding_sense(self, segment: PlacedSegment) -> float:
        """Sense of the motion on a segment, against which friction acts: 1, −1, or 0 at rest."""
        return SENSES[segment.kind]

    def friction_loss(self, sense: Any, sine: Any, s: Any, absolute: Callable[[Any], Any]) -> Any:
        """Friction along the guide over the contact force: N (cos α − this) drives the slide.

        ``sense`` of the motion, 1, 0 or −1; ``absolute``: |·| in the arithmetic of sin α and s.
        """
        if self.friction is None:
            return 0.0
        return absolute(sine) * self.friction.share_of_side_force(s) * (sense * self.side)


@dataclass(frozen=True, eq=False)
class ContactState:
    """Where the follower is, and how its contact stands, in numbers, arrays and enclosures alike.

    Attributes:
        load, omega: what loads it, at a cam speed [rad/s].
        s: s to s'' [mm, per rad]. process: P [N]. sense: of sliding, 1, 0 or −1.
        sine, cosine: of the pressure angle. lever: λ.
    """

    load: ReducedLoad
    omega: float
    s: tuple[Any, ...]
    process: Any
    sense: Any
    sine: Any
    cosine: Any
    lever: Any

    def drive(self) -> Any:
        """G = m a + c v + k s ± F0 + P + W [N], with v = s' ω and a = s'' ω²."""
        return self.load.drive(self.s, self.process, self.omega)

    def contact_force(self) -> Any:
        """N [N], positive where the flank of side σ is pressed: G = N (λ cos α − friction)."""
        resisted = self.load.friction_loss(self.sense, self.sine, self.s[0], np.absolute)
        return self.drive() / (self.lever * self.cosine - resisted)

    def torque(self) -> Any:
        """T [N m]: what the contact force gives along the slide, times s'; friction included."""
        if self.load.friction is None:
            return self.drive() * self.s[1] * MILLI
        return self.contact_force() * self.lever * self.cosine * self.s[1] * MILLI


def pressure_square(load: ReducedLoad, flank: Flank, force: Any, curvature: Any) -> Any:
    """p² of a roller on a flank [MPa²]; where it is not pressed, negative.

    The profile's curvature, 1/R2 = σκ/(1 − Dσκ), has the sign of the flank: hollow flanks fit the
    roller and lower the pressure. With R1 its radius p² = N (1/R1 + 1/R2)/B.
    """
    assert load.contact is not None
    bend = curvature * flank.side
    profile = bend / (1.0 - bend * flank.distance)
    return force * (flank.side / load.contact.stiffness) * (profile + 1.0 / flank.roller)


def face_pressure_square(load: ReducedLoad, force: Any, radius: Any) -> Any:
    """p² under a flat face [MPa²]: p² = N/(B ρ), ρ the profile's radius [mm]."""
    assert load.contact is not None
    return force / (radius * load.contact.stiffness)


@dataclass(frozen=True, eq=False)
class ForceHistory:
    """Forces at n cam angles, rigid bodies at constant speed; arrays are (n,).

    Attributes:
        theta: [rad]. s: (4, n) s to s''' [mm, per rad].
        inertia, damping, spring, process: the parts of the drive, weight with the process [N].
        drive: G, their sum. friction: along the slide [N].
        torque: T on the camshaft [N m].
        contact: by flank, its force where it is pressed; negative where it is not [N].
        pressure: by flank, 0 where it is not pressed [MPa]; empty without a line contact.
        rolling: by flank, how fast a roller on it turns on its pin [rad/s]; of rollers only. In a
            groove it turns the other way on the other flank.
    """

    theta: Array
    s: Array
    inertia: Array
    damping: Array
    spring: Array
    process: Array
    drive: Array
    friction: Array
    torque: Array
    contact: Mapping[str, Array]
    pressure: Mapping[str, Array]
    rolling: Mapping[str, Array]


@np.errstate(divide="ignore", invalid="ignore")  # contact forces where the follower locks, cusps
def history(
    follower: Follower,
    load: ReducedLoad,
    omega: float,
    motion: Motion,
    size: tuple[float, ...],
    theta: ArrayLike,
    side: Side = "right",
) -> ForceHistory:
    """Forces on a finished cam at a speed ω [rad/s], at cam angles (n,) of the turn [rad].

    ``side``: which value to give where the acceleration or the process force jumps.
    """
    angle = np.asarray(theta, dtype=float).ravel()
    s, wrapped = motion.derivatives(angle, 3, side), within_turn(angle, side)
    process = load.process(wrapped, 0, side)
    # Friction acts against the motion of the segment that the angle lies in.
    placed = [segment for segment in motion.segments if segment.angle > 0.0]
    starts = np.array([segment.start for segment in placed])
    which = np.clip(np.searchsorted(starts, wrapped, side=side) - 1, 0, None)
    sense = np.array([load.sliding_sense(segment) for segment in placed])[which]
    places, contact = list[ContactState](), dict[str, Array]()
    pressure, rolling = dict[str, Array](), dict[str, Array]()
    for flank in follower.flanks:
        sine, cosine = pressure_angle_sine_cosine(flank.trace, s, size)
        lever = flank.trace.lever(s, size)
        places.append(ContactState(load, omega, tuple(s), process, sense, sine, cosine, lever))
        force = places[-1].contact_force()
        contact[flank.name] = flank.side * force
        bend, square = flank.trace.curvature_terms(s, size)
        if load.contact is not None and (flank.roller > 0.0 or follower.always_convex):
            found = (
                face_pressure_square(load, force, bend / np.sqrt(square))
                if follower.always_convex
                else pressure_square(load, flank, force, bend / square**1.5)
            )
            pressure[flank.name] = np.sqrt(np.maximum(found, 0.0))
        if flank.roller > 0.0:
            rolling[flank.name] = np.abs(flank.roller_spin(s, size)[0]) * omega
    first, (a, b, c, _) = places[0], load.coefficients(omega)
    resisted = load.friction_loss(sense, first.sine, s[0], np.abs) * np.ones_like(angle)
    return ForceHistory(
        theta=angle,
        s=s,
        inertia=c * s[2],
        damping=b * s[1],
        spring=a * s[0] + load.side * load.preload,
        process=process + load.weight,
        drive=first.drive(),
        friction=first.contact_force() * resisted,
        torque=first.torque(),
        contact=contact,
        pressure=pressure,
        rolling=rolling,
    )
