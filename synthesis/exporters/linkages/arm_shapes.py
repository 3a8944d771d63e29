"""Shapes of a palletising arm from the side: links, parallelograms, the border of what it reaches.

Lengths in mm, or in a power of ten of them; y is the level z, x the radius r.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synthesis.exporters.animations.scene import grouped
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.figures.machine import Moving, Tag
from synthesis.exporters.figures.parts import Box
from synthesis.exporters.linkages import links
from synthesis.linkages.arm import PalletisingArm
from synthesis.linkages.arm.geometry import Arm
from synthesis.linkages.arm.workspace import Arc, Region, image, in_line, regions
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

ROD = 0.11  # of the upper arm: how far beside it its rod runs


@dataclass(frozen=True, eq=False)
class Stage:
    """The arm on its place of the sheet.

    Attributes:
        arm: magnified. regions: what it reaches, in the same scale.
        singular: where the arms are in line within the limits. u: unit of shapes.
        extent: left, bottom, right and top. by: how many times its size it has.
    """

    arm: Arm
    regions: tuple[Region, ...]
    singular: tuple[Arc, ...]
    u: float
    extent: Box
    by: float

    @classmethod
    def of(cls, found: PalletisingArm) -> Stage:
        """The stage of an answer."""
        given = found.spec.arm
        by = links.magnified(given.upper + given.fore)
        arm = Arm(*(by * each for each in vars(given).values()))
        reached = tuple(regions(arm, found.spec.limits))
        singular = tuple(image(arm, *ends) for ends in in_line(found.spec.limits))
        points = [arc.point(s) for one in reached for arc in one.border
                  for s in np.linspace(0.0, 1.0, 33).tolist()]  # fmt: skip
        points += [(-0.1 * arm.upper, 0.0), (arm.shoulder, arm.height)]
        left, bottom, right, top = links.extent_of(points, 0.0)
        u = max(right - left, top - bottom) / links.ACROSS
        return cls(arm, reached, singular, u, links.extent_of(points, 6.0 * u), by)

    def ground(self) -> list[str]:
        """Floor, axis 1, column, what is reached, and where the arms are in line."""
        left, bottom, right, top = self.extent
        u, arm = self.u, self.arm
        half = 3.0 * u
        column = f"M{svg.num(-half)} 0L{svg.num(-half)} {svg.num(0.85 * arm.height)}L" + "L".join(
            f"{svg.num(arm.shoulder + k * half)} {svg.num(arm.height)}" for k in (-1.0, 1.0)
        )
        return [
            *(svg.path("outline body", f"{_way(one.border)}Z") for one in self.regions),
            *(svg.path("line limit", _way([arc])) for arc in self.singular),
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
        """The arm's parts, where they stand first."""
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

    def stood(self, poses: Sequence[tuple[float, float]]) -> list[str]:
        """The arm standing still in several poses."""
        body = []
        for upper, fore in poses:
            still = self.moving(np.array([upper]), np.array([fore]))
            body += self.parts(lambda _: "", still)
        return body


def _way(arcs: Sequence[Arc]) -> str:
    """Arcs, each beginning where the one before ends, as a path."""
    x, y = arcs[0].point(0.0)
    steps = [f"M{svg.num(x)} {svg.num(y)}"]
    for arc in arcs:
        (x, y), radius = arc.point(1.0), svg.num(arc.radius)
        flags = f"{int(abs(arc.sweep) > math.pi)} {int(arc.sweep > 0.0)}"
        steps.append(f"A{radius} {radius} 0 {flags} {svg.num(x)} {svg.num(y)}")
    return "".join(steps)
