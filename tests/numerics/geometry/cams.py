"""Cams of unspecial size, for Hypothesis: any named law or a random spline, any offset."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from hypothesis import strategies as st

from synthesis.catalogue.followers import Follower, TranslatingRoller
from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.motion import Motion, PlacedSegment
from synthesis.catalogue.profile import CamProfile, cam_profile
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Piecewise

TURN = 2.0 * np.pi
PATTERNS = (
    ("rise", "dwell", "return", "dwell"),
    ("dwell", "rise", "return"),
    ("rise", "dwell", "rise", "return", "dwell"),
    ("return", "dwell", "rise", "dwell"),
    ("rise", "return", "dwell", "return"),
)


def gentle(law: Piecewise) -> bool:
    """The follower starts and ends at rest: no jump of the velocity."""
    return abs(law(0.0, 1)) < 1e-9 and abs(law(1.0, 1, "left")) < 1e-9


class AnyCam:
    """A finished cam of any family: what its profile is computed from, and how it is read."""

    motion: Motion
    follower: Follower
    size: tuple[float, ...]
    rotation: str

    @property
    def turns(self) -> float:
        """+1 where it turns counter-clockwise, −1 clockwise."""
        return -1.0 if self.rotation == "cw" else 1.0

    def profile(self, theta: np.ndarray, side: str = "right") -> CamProfile:
        theta = np.asarray(theta, dtype=float)
        return cam_profile(self.motion, self.follower, self.size, self.rotation, theta, side)

    def outline(self, theta: np.ndarray) -> np.ndarray:
        """(2, n) points of the profile."""
        return np.stack([(p := self.profile(theta)).x, p.y])

    def pitch(self, theta: np.ndarray) -> np.ndarray:
        """(2, n) points of the pitch curve."""
        return np.stack([(p := self.profile(theta)).pitch_x, p.pitch_y])

    def traced(self, theta: np.ndarray) -> np.ndarray:
        """(k, 2, n) the traced point in the machine and its derivatives, as they are told."""
        return np.array(self.follower.position(self.motion.derivatives(theta), self.size))

    def inside(self, fraction: float) -> tuple[np.ndarray, np.ndarray]:
        """One cam angle inside each piece of the motion, and the piece's width."""
        breaks = self.motion.curve.breaks
        width = np.diff(breaks)
        return breaks[:-1] + fraction * width, width

    def at_rest(self, *fractions: float) -> np.ndarray:
        """Cam angles at these fractions of every dwell."""
        dwells = [s for s in self.motion.segments if s.kind == "dwell"]
        return np.array([s.start + f * s.angle for s in dwells for f in fractions])


def all_along(motion: Motion, points: int = 300) -> np.ndarray:
    """(4, n) s to s''' all along the turn, both ends of every piece."""
    breaks = motion.curve.breaks
    step = np.linspace(1e-9, 1.0 - 1e-9, points)
    return motion.derivatives((breaks[:-1, None] + np.diff(breaks)[:, None] * step).ravel())


@dataclass(frozen=True)
class Cam(AnyCam):
    """A finished cam with a roller on a slide."""

    motion: Motion
    follower: TranslatingRoller
    e: float
    s0: float
    rotation: str

    @property
    def size(self) -> tuple[float, ...]:
        return self.e, self.s0

    @property
    def Rr(self) -> float:
        return self.follower.roller_radius_mm

    @property
    def Rp(self) -> float:
        return float(np.hypot(self.e, self.s0))

    @property
    def length(self) -> float:
        """The largest radius of the pitch curve, to which lengths are compared."""
        highest = max(max(s.s_start, s.s_end) for s in self.motion.segments)
        return float(np.hypot(self.e, self.s0 + highest))

    def steps(self, fraction: float) -> tuple[np.ndarray, np.ndarray]:
        """The same angles, and how far around each the curves may be read to differentiate them.

        Near enough to stay within the piece and where the direction of the curve changes little.
        """
        theta, width = self.inside(fraction)
        s = self.motion.derivatives(theta)
        X = self.s0 + s[0]
        return theta, np.minimum(0.15 * width, 0.1 * X / (0.5 * X + abs(s[2])))


@cache
def unspecial(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers between two ends, none of them round."""
    return st.integers(0, 999_999).map(lambda n: low + (high - low) * (n + 0.414213562) / 1e6)


@st.composite
def splines(draw: st.DrawFn) -> Piecewise:
    """A rising spline from rest to rest: degree 3 to 5, uneven knots, coefficients in order."""
    degree = draw(st.integers(3, 5))
    gaps = np.array(draw(st.lists(unspecial(0.5, 1.0), min_size=5, max_size=9)))
    breaks = np.concatenate([[0.0], np.cumsum(gaps)]) / gaps.sum()
    breaks[-1] = 1.0
    space = SplineSpace(degree, breaks)
    free = space.size - 6
    steps = np.array([draw(unspecial(0.5, 1.0)) for _ in range(free + 1)])
    middle = np.cumsum(steps)[:-1] / steps.sum()
    return space.curve(np.concatenate([np.zeros(3), middle, np.ones(3)]))


@st.composite
def motions(draw: st.DrawFn, lift: float = 1.0, only_gentle: bool = False) -> Motion:
    """Rises, dwells and returns of uneven angles and lifts; the longest travel is about lift."""
    kinds = draw(st.sampled_from(PATTERNS))
    shares = np.array([draw(unspecial(0.3, 1.0)) for _ in kinds])
    ends = TURN * np.concatenate([[0.0], np.cumsum(shares)]) / shares.sum()
    ends[-1] = TURN
    gains = {kind: np.array([draw(unspecial(0.4, 1.0)) for k in kinds if k == kind])
             for kind in ("rise", "return")}  # fmt: skip
    gains = {kind: list(gain / gain.sum()) for kind, gain in gains.items()}
    moves = {"rise": 1.0, "return": -1.0}
    steps = [lift * moves[k] * gains[k].pop() if k in moves else 0.0 for k in kinds]
    levels = np.concatenate([[0.0], np.cumsum(steps)])
    levels[-1] = levels[0]
    levels -= levels.min()
    placed = []
    for i, kind in enumerate(kinds):
        law = Piecewise.of([0.0, 1.0], [[0.0]])
        if kind != "dwell":
            law = draw(laws(kind, only_gentle))
        placed.append(
            PlacedSegment(i, kind, ends[i], ends[i + 1] - ends[i], levels[i], levels[i + 1], law)
        )
    return Motion.of(placed)


@cache
def laws(kind: str, only_gentle: bool = False) -> st.SearchStrategy[Piecewise]:
    """A named law, whatever is registered, or a random spline."""
    named = [law.curve(kind) for law in LAWS.values()]
    named = [curve for curve in named if not only_gentle or gentle(curve)]
    return st.one_of(splines(), st.sampled_from(named))


@st.composite
def cams(
    draw: st.DrawFn,
    knife_edge: bool = True,
    only_gentle: bool = False,
    lifts: tuple[float, float] = (0.2, 1.0),
) -> Cam:
    """Prime radius 0.1 to 1000; against it the lift 0.2 to 1, offset and roller below 0.6."""
    Rp = 10.0 ** draw(unspecial(-1.0, 3.0))
    lift = Rp * draw(unspecial(*lifts))
    e = Rp * draw(st.sampled_from([-1.0, 1.0])) * draw(unspecial(0.02, 0.6))
    Rr = Rp * draw(unspecial(0.05, 0.5))
    if knife_edge and draw(st.integers(0, 4)) == 0:
        Rr = 0.0
    motion = draw(motions(lift, only_gentle))
    rotation = draw(st.sampled_from(["ccw", "cw"]))
    follower = TranslatingRoller(roller_radius_mm=Rr, offset_mm=e)
    return Cam(motion, follower, e, float(np.sqrt(Rp**2 - e**2)), rotation)
