"""The turned blank of a spatial cam: a hub, and a rim from the ribs' tops to the grooves' floor."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from synthesis.errors import InputError
from synthesis.exporters.options import BoreDiameter, Options
from synthesis.machines.spatial.grooves import GrooveSections
from synthesis.numerics.geometry.charts import Chart
from synthesis.numerics.geometry.swept_roller import cross, dot, norm
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

END_MARGIN = 2.0  # roller radii from the last axis to the end: leaves one radius of material
RIM_ANGLES = np.linspace(0.0, FULL_TURN, 16, endpoint=False)
Spacing = Callable[[float, float, int], Array]
Clearance = Annotated[float, Field(ge=0.0, le=1e4)]


@dataclass(frozen=True, kw_only=True)
class BlankOptions(Options):
    """The body that the grooves are cut into."""

    bore_mm: BoreDiameter = None
    width_mm: Annotated[
        float | None,
        Field(
            gt=0.0,
            le=1e5,
            description="Width between two flat ends at equal distances from the common "
            "perpendicular; left out: the cam's own, or as far as the rollers mesh, or one roller "
            "radius beyond their grooves.",
        ),
    ] = None
    tip_clearance_mm: Annotated[
        Clearance,
        Field(description="Clearance between the ribs' tops and the rollers' inner ends."),
    ] = 0.0
    end_clearance_mm: Annotated[
        Clearance,
        Field(description="Clearance between the grooves' floor and the rollers' outer ends."),
    ] = 1.0


@dataclass(frozen=True, eq=False)
class Blank:
    """The body before grooves are cut.

    Attributes:
        chart: its coordinates. depth: (m,) from the ribs' tops to the floor [mm].
        low, high: (m,) places across of its two ends, at every depth.
        bore: radius of the bore, 0: none [mm].
    """

    chart: Chart
    depth: Array
    low: Array
    high: Array
    bore: float = 0.0

    @classmethod
    def of(
        cls, cuts: GrooveSections, options: BlankOptions, depths: int, spaced: Spacing = np.linspace
    ) -> Blank:
        """The blank for a machine's rollers, at so many depths with the given spacing.

        Raises:
            InputError: nothing is left of the ribs, of the width, or around the bore.
        """
        top, root = _depth_range(cuts)
        top, root = top + options.tip_clearance_mm, root + options.end_clearance_mm
        if not top < root:
            raise InputError(
                "/tip_clearance_mm", options.tip_clearance_mm,
                f"The grooves are {root - top + options.tip_clearance_mm:.6g} mm deep.",
                "Reduce the clearance.",
            )  # fmt: skip
        depth = spaced(top, root, depths)
        # Where no width is given the blank reaches as far as the rollers mesh, or a little farther.
        roller, width = cuts.cam.swept.roller, options.width_mm
        across = cuts.to_chart(cuts.axes(roller.middle))[2]
        room = 0.0 if np.isfinite(cuts.mesh[0]) else END_MARGIN * roller.radius
        low, high = (np.full(depths, end) for end in (np.min(across) - room, np.max(across) + room))
        faces = cuts.cam.faces if width is None else (-0.5 * width, 0.5 * width)
        if np.all(np.isfinite(faces)):
            low = np.maximum(low, cuts.chart.across_at_height(depth, faces[0]))
            high = np.minimum(high, cuts.chart.across_at_height(depth, faces[1]))
        blank = cls(cuts.chart, depth, low, high, 0.5 * (options.bore_mm or 0.0))
        thin = float(
            np.min(cuts.chart.meridian(depth[-1:], np.linspace(low[-1], high[-1], 181))[0])
        )
        if thin <= 0.0:
            raise InputError(
                "/end_clearance_mm", options.end_clearance_mm,
                f"The grooves' floor reaches {-thin:.6g} mm beyond the cam's axis: with these "
                "rollers and this centre distance nothing is left of the body.",
                "Reduce the clearance, increase the centre distance, or use shorter rollers.",
            )  # fmt: skip
        if thin <= blank.bore:
            raise InputError(
                "/bore_mm", options.bore_mm,
                f"The grooves' floor is {thin:.6g} mm from the cam's axis.",
                f"Choose a diameter below {2.0 * thin:.6g} mm.",
            )  # fmt: skip
        return blank

    @property
    def heights(self) -> tuple[float, float]:
        """Heights of the hub's two faces along the cam's axis [mm]."""
        ends = np.array([self.low[-1], self.high[-1]])
        low, high = self.chart.meridian(self.depth[-1:], ends)[1]
        return float(low), float(high)


def _depth_range(cuts: GrooveSections) -> tuple[float, float]:
    """Depth of the ribs' tops, and the largest depth of the rollers' rims [mm]."""
    roller, way = cuts.cam.swept.roller, cuts.cam.swept.joint.velocity_per_q
    u = cuts.directions()
    ends = np.array([roller.inner, roller.outer])
    deepest = [*cuts.chart.depth_of_place(ends)]
    for rho, radius in zip(ends, roller.profile(ends)[0], strict=True):
        axis = cuts.axes(rho)
        one = way(axis) - dot(way(axis), u) * u
        one = one / norm(one)
        rim = axis + radius * (np.cos(RIM_ANGLES) * one + np.sin(RIM_ANGLES) * cross(u, one))
        deepest += [np.max(cuts.to_chart(axis)[1]), np.max(cuts.to_chart(rim)[1])]
    return float(min(cuts.chart.depth_of_place(ends))), float(max(deepest))
