"""A palletising arm from above: what it reaches as its base turns, x to the right, y upwards."""

from __future__ import annotations

import math
from dataclasses import dataclass

from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.figures.machine import Tag
from synthesis.exporters.figures.parts import Box
from synthesis.exporters.linkages import links
from synthesis.linkages.arm import PalletisingArm
from synthesis.linkages.arm.limits import Span
from synthesis.units import DEGREE, FULL_TURN


@dataclass(frozen=True)
class Plan:
    """What is reached at one level or another, in front of the base and over it.

    Attributes:
        rings: nearest and farthest reach, each with the angles of the base that reach there [rad].
        radius: of all that is shown. by: how many times its size it has.
    """

    rings: tuple[tuple[Span, Span], ...]
    radius: float
    by: float

    @classmethod
    def of(cls, found: PalletisingArm) -> Plan:
        """The plan of an answer, as large as the arm from the side is."""
        spec = found.spec
        by = links.magnified(spec.upper_arm_mm + spec.forearm_mm)
        nearest = by * min(region.r_min.value_mm for region in found.regions)
        farthest = by * max(region.r_max.value_mm for region in found.regions)
        low, high = spec.base_deg.min * DEGREE, spec.base_deg.max * DEGREE
        front = ((max(nearest, 0.0), farthest), (low, high))
        over = ((max(-farthest, 0.0), -nearest), (low + math.pi, high + math.pi))
        rings = tuple(ring for ring in (front, over) if ring[0][1] > 0.0)
        return cls(rings, by * found.reach_mm, by)

    @property
    def u(self) -> float:
        """The unit of shapes."""
        return 2.0 * self.radius / links.ACROSS

    @property
    def extent(self) -> Box:
        """All that is reached, whichever way the base turns."""
        half = self.radius + 4.0 * self.u
        return -half, -half, half, half

    def shapes(self, tag: Tag) -> list[str]:
        """What is reached, axis 1, and the base's way of standing as a part."""
        left, _, right, _ = self.extent
        return [
            *(svg.path("outline body", _ring(*ring)) for ring in self.rings),
            svg.line("line centre", left, 0.0, right, 0.0),
            svg.line("line centre", 0.0, left, 0.0, right),
            f"<g {tag('base')}>",
            *links.bar(self.radius / 3.0, 2.0 * self.u),
            "</g>",
        ]


def _ring(radii: Span, turned: Span) -> str:
    """A piece of a ring, or all of it, as a path."""
    low, high = turned
    if high - low < FULL_TURN:
        out, back = _arc(radii[1], low, high), _arc(radii[0], high, low)
        return f"M{out[0]}{out[1]}L{back[0]}{back[1]}Z"
    return "".join(f"M{start}{steps}Z" for start, steps in
                   (_arc(radius, 0.0, FULL_TURN) for radius in radii if radius > 0.0))  # fmt: skip


def _arc(radius: float, start: float, end: float) -> tuple[str, str]:
    """Where an arc about axis 1 begins, and its steps: three, each less than a half turn."""

    def point(angle: float) -> str:
        return f"{svg.num(radius * math.cos(angle))} {svg.num(radius * math.sin(angle))}"

    r, sweep = svg.num(radius), int(end > start)
    stops = [start + (end - start) * k / 3.0 for k in (1, 2, 3)]
    return point(start), "".join(f"A{r} {r} 0 0 {sweep} {point(stop)}" for stop in stops)
