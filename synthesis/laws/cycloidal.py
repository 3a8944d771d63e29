"""Cycloidal law (VDI 2143: inclined sine, Bestehorn)."""

from __future__ import annotations

from math import pi
from typing import ClassVar, Literal

from synthesis.laws.base import MotionLaw
from synthesis.motion import StretchKind
from synthesis.numerics.piecewise import Piecewise


class Cycloidal(MotionLaw):
    """s = x − sin(2πx)/2π."""

    kind: Literal["cycloidal"] = "cycloidal"
    title: ClassVar[str] = "Cycloidal (inclined sine, Bestehorn)"
    source: ClassVar[str] = "VDI 2143-1; Norton, Cam Design and Manufacturing Handbook, ch. 2"

    def curve(self, stretch: StretchKind) -> Piecewise:
        return Piecewise.of([0.0, 1.0], [[0.0, 1.0]], [[(-1.0 / (2.0 * pi), 2.0 * pi, 0.0)]])
