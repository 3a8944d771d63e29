"""Cams built by hand, and their extremes by dense sampling: what the certificate is held against.

The formulas are the textbook's for a translating follower (Rothbart; Norton ch. 7), not the
certificate's path rule.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from synthesis.catalogue.followers import TranslatingRoller
from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.limits import Machine
from synthesis.catalogue.motion import FreeLaw, Motion, PlacedSegment
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Piecewise

TURN = 2.0 * np.pi
STILL = Piecewise.of([0.0, 1.0], [[0.0]])
Law = Piecewise | None
Segment = tuple[str, float, float, Law]  # kind, angle [any unit], lift [mm], law


def motion_of(segments: Sequence[Segment], free: FreeLaw | None = None) -> Motion:
    """Segments in order, their angles scaled to one turn; splines get ``free`` as their promise."""
    turn = sum(angle for _, angle, _, _ in segments)
    start, level, placed = 0.0, 0.0, []
    for i, (kind, angle, lift, law) in enumerate(segments):
        beta = TURN - start if i == len(segments) - 1 else TURN * angle / turn
        end = level + {"rise": lift, "return": -lift, "dwell": 0.0}[kind]
        promise = None if kind == "dwell" else free
        placed.append(PlacedSegment(i, kind, start, beta, level, end, law or STILL, promise))
        start, level = start + beta, end
    return Motion.of(placed)


def spline(degree: int, breaks: np.ndarray, bumps: np.ndarray | None = None) -> Piecewise:
    """A law with s' = s'' = 0 at its ends: the 3-4-5 law's values as control points, and bumps."""
    space = SplineSpace(degree, breaks)
    knots = space.knots
    x = np.array([knots[i + 1 : i + degree + 1].mean() for i in range(space.size)])
    control = x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
    if bumps is not None:
        control = control + bumps
    control[:3], control[-3:] = 0.0, 1.0
    return space.curve(control)


@dataclass(frozen=True)
class Cam:
    """A finished cam with a translating follower."""

    motion: Motion
    roller: float
    e: float
    s0: float
    omega: float = 10.0

    @property
    def size(self) -> tuple[float, float]:
        return self.e, self.s0

    @property
    def machine(self) -> Machine:
        return Machine(TranslatingRoller(roller_radius_mm=self.roller), self.omega)

    def segments(self, *kinds: str) -> list[int]:
        return [s.index for s in self.motion.segments if s.kind in kinds or not kinds]

    def mirrored(self) -> "Cam":
        """The same cam seen from behind: it turns the other way, offset to the other side."""
        return replace(self, motion=backwards(self.motion), e=-self.e)


def flipped(law: Piecewise) -> Piecewise:
    """x ↦ 1 − g(1 − x)."""
    back = law.mirror()
    poly = -back.poly
    poly[:, 0] += 1.0
    return Piecewise(back.breaks, back.origins, poly, back.waves * np.array([-1.0, 1.0, 1.0]))


def backwards(motion: Motion) -> Motion:
    """The same motion run through the other way, as by a cam that turns the other way."""
    swap = {"rise": "return", "return": "rise", "dwell": "dwell"}
    placed = []
    for i, s in enumerate(reversed(motion.segments)):
        law = s.law if s.kind == "dwell" else flipped(s.law)
        placed.append(
            PlacedSegment(i, swap[s.kind], 2.0 * np.pi - s.end, s.angle, s.s_end, s.s_start, law)
        )
    return Motion.of(placed)


# -- the textbook's formulas ------------------------------------------------------------------


def alpha(cam: Cam, s: np.ndarray) -> np.ndarray:
    return np.arctan((s[1] - cam.e) / (cam.s0 + s[0]))


def kappa(cam: Cam, s: np.ndarray) -> np.ndarray:
    x, u = cam.s0 + s[0], s[1] - cam.e
    return (x**2 + u * (2.0 * s[1] - cam.e) - x * s[2]) / (x**2 + u**2) ** 1.5


def radius(cam: Cam, s: np.ndarray) -> np.ndarray:
    return np.hypot(cam.e, cam.s0 + s[0])


def derivative(order: int) -> Callable[[Cam, np.ndarray], np.ndarray]:
    return lambda cam, s: s[order]


FORMULAS = {
    "pressure_angle": alpha,
    "pitch_curvature": kappa,
    "pitch_radius": radius,
    "velocity": derivative(1),
    "acceleration": derivative(2),
    "jerk": derivative(3),
}


def on_pieces(cam: Cam, quantity: str, pieces: Sequence[int], x: np.ndarray) -> np.ndarray:
    """The quantity at x (pieces, points), by each piece's own formula, at its ends as well."""
    where = np.repeat(pieces, x.shape[1])
    s = np.stack([cam.motion.curve.at(x.ravel(), where, order) for order in range(4)])
    return FORMULAS[quantity](cam, s).reshape(x.shape)


def pieces_of(cam: Cam, segments: Sequence[int]) -> list[int]:
    owners = [s.index for s in cam.motion.segments if s.angle > 0.0 for _ in range(s.law.count)]
    return [i for i, owner in enumerate(owners) if owner in segments]


def samples(
    cam: Cam, quantity: str, segments: Sequence[int], points: int
) -> tuple[list[int], np.ndarray, np.ndarray]:
    """Pieces of these segments, ``points`` places on each, ends included, and the values there."""
    pieces = pieces_of(cam, segments)
    breaks = cam.motion.curve.breaks
    x = np.array([np.linspace(*breaks[piece : piece + 2], points) for piece in pieces])
    return pieces, x, on_pieces(cam, quantity, pieces, x)


def sampled(
    cam: Cam, quantity: str, segments: Sequence[int], sign: int, points: int
) -> tuple[float, float]:
    """Largest value of sign · quantity and where: samples, the best of them polished."""
    pieces, x, values = samples(cam, quantity, segments, points)
    row, i = np.unravel_index(np.argmax(sign * values), values.shape)
    low, high = x[row, max(i - 1, 0)], x[row, min(i + 1, points - 1)]

    def negative(t: float) -> float:
        return -sign * float(on_pieces(cam, quantity, [pieces[row]], np.array([[t]]))[0, 0])

    polished = minimize_scalar(
        negative, bounds=(low, high), method="bounded", options={"xatol": 1e-13}
    )
    return max(float(sign * values[row, i]), -float(polished.fun)), float(polished.x)


# -- for Hypothesis ---------------------------------------------------------------------------

RESTING = sorted(
    kind
    for kind, law in LAWS.items()
    if all(abs(law.curve("rise")(1.0, order, "left")) < 1e-9 for order in (1, 2))
)


@st.composite
def laws(draw: st.DrawFn) -> Piecewise:
    """A named law that rests at both ends, or a random spline."""
    if draw(st.booleans()):
        return LAWS[draw(st.sampled_from(RESTING))].curve("rise")
    degree, count = draw(st.sampled_from([3, 4, 5])), draw(st.integers(4, 14))
    steps = np.array(draw(st.lists(st.floats(0.2, 1.0), min_size=count, max_size=count)))
    breaks = np.concatenate([[0.0], np.cumsum(steps) / np.sum(steps)])
    breaks[-1] = 1.0
    size = count + degree
    bumps = np.array(draw(st.lists(st.floats(-0.04, 0.04), min_size=size, max_size=size)))
    return spline(degree, breaks, bumps)


@st.composite
def cams(draw: st.DrawFn) -> Cam:
    """Rise, dwell, return, dwell in unspecial sizes."""
    lift = draw(st.floats(0.37, 61.0))
    angles = [draw(st.floats(7.3, 130.0)) for _ in range(4)]
    rise, back = draw(laws()), draw(laws())
    segments: list[Segment] = [
        ("rise", angles[0], lift, rise),
        ("dwell", angles[1], 0.0, None),
        ("return", angles[2], lift, back),
        ("dwell", angles[3], 0.0, None),
    ]
    s0 = draw(st.floats(0.4, 3.0)) * lift
    e = draw(st.just(0.0) | st.floats(1e-6, 0.9)) * s0 * draw(st.sampled_from([-1.0, 1.0]))
    return Cam(motion_of(segments), draw(st.floats(0.0, 0.3)) * s0, e, s0)
