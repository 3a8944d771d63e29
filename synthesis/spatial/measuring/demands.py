"""Windows and points of a program on the finished motion: the largest and least value on each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from synthesis.limits.demand import EXACT, TRAVEL, Demand
from synthesis.motion import Stretch
from synthesis.numerics.peaks import peak
from synthesis.spatial.cam import SpatialCam
from synthesis.spatial.measuring.follower import EVIDENCE
from synthesis.spatial.measuring.found import Bound, Found, Kind
from synthesis.spatial.spec import SpatialCamSpec


def kept(spec: SpatialCamSpec, cam: SpatialCam) -> Iterator[tuple[Kind, Found]]:
    """Every bound of every window and point."""
    for stretch, segment in zip(cam.motion.stretches, spec.program, strict=True):
        for demand in segment.demands(stretch.index):
            yield from _Asked(demand, stretch, spec).sides()


@dataclass(frozen=True, eq=False)
class _Asked:
    """A demand, and the stretch that has to keep it."""

    demand: Demand
    stretch: Stretch
    spec: SpatialCamSpec

    def sides(self) -> Iterator[tuple[Kind, Found]]:
        """Its largest and its least value, those that are bounded."""
        demand, travel = self.demand, self.spec.machine.travel
        rate = travel.rate(demand.order, self.spec.omega)
        size = abs(self.stretch.lift) / self.stretch.angle**demand.order * rate
        spare = EXACT * size if demand.exact else 0.0
        for bound, largest in ((demand.max, True), (demand.min, False)):
            if bound is None:
                continue
            end = "max" if largest else "min"
            name = demand.name if demand.name.endswith(end) else f"{demand.name}_{end}"
            asked = Bound(bound + (spare if largest else -spare), demand.field)
            kind = Kind(name, travel.told(demand.order), largest, must=asked)
            value, theta = self._extreme(rate, largest)
            yield kind, Found(value, value, EVIDENCE, theta)

    def _extreme(self, rate: float, largest: bool) -> tuple[float, float]:
        """Its extreme on the wire, and where [rad]."""
        order, stretch = self.demand.order, self.stretch
        back = order == TRAVEL and stretch.lift < 0.0
        factor = -rate if back else rate
        start = factor * stretch.s_start if order == TRAVEL else 0.0
        low, high = (stretch.start + x * stretch.angle for x in self.demand.part)
        curve = stretch.placed()
        sign = 1.0 if largest == (factor > 0.0) else -1.0
        if low == high:
            at = np.array([low])
            both = [float(curve(at, order, side)[0]) for side in ("left", "right")]
            value = max(both, key=lambda each: sign * each)
            return factor * value - start, low
        found, theta = peak(curve.within(low, high), [0.0] * order + [sign])
        return factor * sign * found - start, theta
