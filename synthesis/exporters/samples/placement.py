"""Where points stand: in the cam's own frame, or turned and shifted to its place on a shaft."""

from __future__ import annotations

import math

from synthesis.catalogue.profile import CamProfile
from synthesis.exporters.options import CurveOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.numerics.piecewise import Array


def placed(cam: Cam, options: CurveOptions, at: CamProfile) -> tuple[Array, Array]:
    """x and y of the cam's curve [mm], turned by the options' angle."""
    return turned(options.turn_deg, *cam.place(at))


def turned(degrees: float, x: Array, y: Array) -> tuple[Array, Array]:
    """Turned about the cam's axis, counter-clockwise positive."""
    if degrees == 0.0:
        return x, y
    cos, sin = _cos_sin(degrees)
    return cos * x - sin * y, sin * x + cos * y


def _cos_sin(degrees: float) -> tuple[float, float]:
    """Exact at whole quarters of a turn."""
    quarters, rest = divmod(degrees, 90.0)
    cos, sin = math.cos(math.radians(rest)), math.sin(math.radians(rest))
    for _ in range(int(quarters) % 4):
        cos, sin = -sin, cos
    return cos, sin
