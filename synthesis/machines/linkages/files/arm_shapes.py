"""Shapes of a palletising arm: links, parallelograms and workspace from the side, plan from above.

Lengths in mm, or in a power of ten of them; y is the level z, x the radius r.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synthesis.exporters.animations.animation_page import tag
from synthesis.exporters.animations.scene import grouped
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.figures.machine import Moving, Tag
from synthesis.exporters.figures.parts import Box
from synthesis.machines.linkages.arm import PalletisingArm
from synthesis.machines.linkages.arm.geometry import Arm
from synthesis.machines.linkages.arm.workspace import (
    Arc,
    Region,
    Span,
    regions,
    singular_segments,
    tool_arc,
)
from synthesis.machines.linkages.files import links
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

ROD = 0.11  # of the upper arm: distance of the parallelogram's rod


@dataclass(frozen=True, eq=False)
class Stage:
    """The arm as drawn from the side.

    Attributes:
        arm: scaled for drawing. regions: its workspace, in the same scale.
        singular: where the arms are in line within the limits. u: unit of shapes.
        extent: left, bottom, right and top. by: scale factor.
    """

    arm: Arm
    regions: tuple[Region, ...]
    singular: tuple[Arc, ...]
    u: float
    extent: Box
    by: float

    @classmethod
    def of(cls, found: PalletisingArm) -> Stage:
        """The stage for an answer."""
        given = found.spec.arm
        by = links.display_scale(given.upper + given.fore)
        arm = Arm(*(by * each for each in vars(given).values()))
        reached = tuple(regions(arm, found.spec.limits))
        singular = tuple(tool_arc(arm, *ends) for ends in singular_segments(found.spec.limits))
        points = [arc.point(s) for one in reached for arc in one.border
                  for s in np.linspace(0.0, 1.0, 33).tolist()]  # fmt: skip
        points += [(-0.1 * arm.upper, 0.0), (arm.shoulder, arm.height)]
        return cls(arm, reached, singular, *links.unit_and_extent(points, 6.0), by)

    def ground(self) -> list[str]:
        """Floor, axis 1, column, workspace, and the singular arcs."""
        left, bottom, right, top = self.extent
        u, arm = self.u, self.arm
        half = 3.0 * u
        column = f"M{svg.num(-half)} 0L{svg.num(-half)} {svg.num(0.85 * arm.height)}L" + "L".join(
            f"{svg.num(arm.shoulder + k * half)} {svg.num(arm.height)}" for k in (-1.0, 1.0)
        )
        return [
            *(svg.path("outline body", f"{_arc_path(one.border)}Z") for one in self.regions),
            *(svg.path("line limit", _arc_path([arc])) for arc in self.singular),
            *links.hatched(left + 2.0 * u, right - 2.0 * u, 0.0, u),
            svg.line("line centre", 0.0, bottom, 0.0, top),
            svg.path("outline rest", f"{column}L{svg.num(half)} 0Z"),
        ]

    def moving(self, upper: Array, fore: Array) -> list[Moving]:
        """The parts that move, along arm angles (n,) [rad]."""
        arm = self.arm
        elbow = np.stack([arm.shoulder + arm.upper * np.sin(upper),
                          arm.height + arm.upper * np.cos(upper)], axis=1)  # fmt: skip
        wrist = elbow + arm.fore * np.stack([np.cos(fore), -np.sin(fore)], axis=1)
        first, second = 90.0 - upper[:, None] / DEGREE, -fore[:, None] / DEGREE
        return [
            Moving("upper", "turn", first), Moving("rod", "turn", first),
            Moving("elbow", "shift", elbow), Moving("fore", "turn", second),
            Moving("fore-rod", "turn", second), Moving("wrist", "shift", wrist),
        ]  # fmt: skip

    def parts(self, tag: Tag, moving: Sequence[Moving]) -> list[str]:
        """The arm's parts in their first positions."""
        arm, u = self.arm, self.u
        beside = ROD * arm.upper

        def at(x: float, y: float, body: Sequence[str]) -> list[str]:
            return [f'<g transform="translate({svg.num(x)} {svg.num(y)})">', *body, "</g>"]

        def rod(name: str, length: float) -> list[str]:
            return grouped(name, tag, moving, [svg.line("line axis", 0.0, 0.0, length, 0.0)])

        upper = grouped("upper", tag, moving, links.bar(arm.upper, 2.0 * u))
        fore = grouped("fore", tag, moving, links.bar(arm.fore, 1.6 * u))
        plate = svg.path("outline rest", f"M0 0L{svg.num(-beside)} 0L0 {svg.num(beside)}Z")
        hand = svg.path("line outline", f"M0 {svg.num(beside)}L0 0H{svg.num(arm.wrist)}")
        tool = svg.line("outline", arm.wrist, 0.0, arm.wrist, -arm.tool)
        return [
            *at(arm.shoulder - beside, arm.height, rod("rod", arm.upper)),
            *at(arm.shoulder, arm.height, upper),
            *grouped("elbow", tag, moving, [
                plate, *fore, *at(0.0, beside, rod("fore-rod", arm.fore))]),
            *grouped("wrist", tag, moving, [
                hand, tool, links.pin(0.0, 0.0, u),
                svg.circle("mark", arm.wrist, -arm.tool, 0.9 * u)]),
        ]  # fmt: skip


def _arc_path(arcs: Sequence[Arc]) -> str:
    """A chain of arcs as a path."""
    x, y = arcs[0].point(0.0)
    steps = [f"M{svg.num(x)} {svg.num(y)}"]
    for arc in arcs:
        (x, y), radius = arc.point(1.0), svg.num(arc.radius)
        flags = f"{int(abs(arc.sweep) > math.pi)} {int(arc.sweep > 0.0)}"
        steps.append(f"A{radius} {radius} 0 {flags} {svg.num(x)} {svg.num(y)}")
    return "".join(steps)


def plan_view(found: PalletisingArm, by: float) -> tuple[Box, list[str]]:
    """The workspace from above with the base as a moving part, in the scale of the side view.

    The tool reaches an annular sector in front of the base, and one over it, turned by 180°.

    Returns:
        bounding box for all base angles, and the elements.
    """
    radius, base = by * found.reach_mm, found.spec.base_deg
    nearest = by * min(region.r_min.value_mm for region in found.regions)
    farthest = by * max(region.r_max.value_mm for region in found.regions)
    low, high = base.min * DEGREE, base.max * DEGREE
    sectors = (
        ((max(nearest, 0.0), farthest), (low, high)),
        ((max(-farthest, 0.0), -nearest), (low + math.pi, high + math.pi)),
    )
    u = 2.0 * radius / links.ACROSS
    half = radius + 4.0 * u
    return (-half, -half, half, half), [
        *(svg.path("outline body", _ring(*sector)) for sector in sectors if sector[0][1] > 0.0),
        svg.line("line centre", -half, 0.0, half, 0.0),
        svg.line("line centre", 0.0, -half, 0.0, half),
        f"<g {tag('base')}>",
        *links.bar(radius / 3.0, 2.0 * u),
        "</g>",
    ]


def _ring(radii: Span, turned: Span) -> str:
    """An annular sector, or the whole ring, as a path."""
    low, high = turned
    if high - low < FULL_TURN:
        out, back = _arc(radii[1], low, high), _arc(radii[0], high, low)
        return f"M{out[0]}{out[1]}L{back[0]}{back[1]}Z"
    return "".join(f"M{start}{steps}Z" for start, steps in
                   (_arc(radius, 0.0, FULL_TURN) for radius in radii if radius > 0.0))  # fmt: skip


def _arc(radius: float, start: float, end: float) -> tuple[str, str]:
    """Start of an arc about axis 1, and three SVG arcs, each less than a half turn."""

    def point(angle: float) -> str:
        return f"{svg.num(radius * math.cos(angle))} {svg.num(radius * math.sin(angle))}"

    r, sweep = svg.num(radius), int(end > start)
    stops = [start + (end - start) * k / 3.0 for k in (1, 2, 3)]
    return point(start), "".join(f"A{r} {r} 0 0 {sweep} {point(stop)}" for stop in stops)
