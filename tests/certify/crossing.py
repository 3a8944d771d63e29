"""Whether a cam cuts itself, by brute force: dense samples, every one against every other.

The curve is the textbook's for a translating roller, its normal comes from differences between
neighbouring samples, and no criterion decides which pairs are looked at: all are.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from synthesis.catalogue.motion import Motion
from synthesis.certify.piecewise_motion import PiecewiseMotion
from synthesis.numerics.piecewise import Piecewise
from tests.certify.cams import TURN, motion_of

POINTS = 1500


@dataclass(frozen=True)
class Sampled:
    """Least distance of a roller's centre from the profile, where, and how coarse the samples are.

    Attributes:
        distance: [mm]. profile, roller: cam angles [rad]. step: longest step between samples [mm].
    """

    distance: float
    profile: float
    roller: float
    step: float


def pitch(motion: Motion, e: float, s0: float, theta: np.ndarray) -> np.ndarray:
    """Roller centres (n, 2) on a ccw cam."""
    X = s0 + motion.derivatives(theta, 0)[0]
    cos, sin = np.cos(theta), np.sin(theta)
    return np.stack([e * cos + X * sin, X * cos - e * sin], axis=1)


def brute(
    motion: Motion, e: float, s0: float, offset: float, span: tuple[float, ...] = ()
) -> Sampled:
    """Every profile sample against every roller centre.

    Args:
        motion, e, s0: the cam. offset: roller radius, negative for a profile outside the curve.
        span: centres and half width [rad] of a window for either angle; all round if not given.
    """
    first = second = TURN * (np.arange(POINTS) + 0.31) / POINTS
    if span:
        first, second = (at + span[2] * np.linspace(-1.0, 1.0, 401) for at in span[:2])
    d = 1e-6
    along = pitch(motion, e, s0, first + d) - pitch(motion, e, s0, first - d)
    along /= np.hypot(*along.T)[:, None]
    outward = np.stack([-along[:, 1], along[:, 0]], axis=1)
    profile = pitch(motion, e, s0, first) - offset * outward
    centres = pitch(motion, e, s0, second)
    apart = np.hypot(*(profile[:, None, :] - centres).T).T
    i, j = np.unravel_index(np.argmin(apart), apart.shape)
    step = float(np.max(np.hypot(*np.diff(centres, axis=0).T)))
    return Sampled(float(apart[i, j]), float(first[i]), float(second[j]), step)


def sharpest(motion: Motion, e: float, s0: float, sign: float = 1.0) -> float:
    """Smallest radius of the pitch curve [mm], convex (sign 1) or hollow (−1)."""
    s, v, a, _ = motion.derivatives(np.linspace(0.0, TURN, 20001)[:-1])
    X, u = s0 + s, v - e
    bend = sign * (X * X + u * (2.0 * v - e) - X * a) / (X * X + u * u) ** 1.5
    return float(1.0 / np.max(bend))


@dataclass(frozen=True)
class Horseshoe:
    """An ellipse of half axes ``length`` and ``thickness``, bent round a circle; clockwise."""

    radius: float
    length: float
    thickness: float

    def point(self, u: Any) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
        """Point and derivative at u, of numbers or of models."""
        cos, sin, radius = np.cos(u), np.sin(u), self.radius
        bend, out = cos * (self.length / radius), radius - self.thickness * sin
        turn, grow = sin * (-self.length / radius), cos * (-self.thickness)
        c, s = np.cos(bend), np.sin(bend)
        return (out * s, out * c), (grow * s + out * c * turn, grow * c - out * s * turn)

    def motion(self) -> PiecewiseMotion:
        """A motion that says nothing but the angle itself."""
        return PiecewiseMotion(
            motion_of([("rise", 1.0, TURN, Piecewise.of([0.0, 1.0], [[0.0, 1.0]]))])
        )

    def trace(self, s: Any) -> tuple[tuple[Any, Any], ...]:
        """The point as the machine sees it, turned with the cam by s itself."""
        (x, y), (dx, dy) = self.point(s[0])
        c, sn = np.cos(s[0]), np.sin(s[0])
        px, py = x * c - y * sn, x * sn + y * c
        return (px, py), (dx * c - dy * sn - py, dx * sn + dy * c + px)
