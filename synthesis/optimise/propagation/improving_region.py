"""The improving region: bounds of the size and of the traced point of every better cam.

A limit on curvature or on Hertz pressure speaks of the point that traces a curve: its height X and
its speed past the axis u = X' − e. Within bounds of (X, u, e) the limit implies linear rows
(``rows``; McCormick's estimators, in the catalogue). ``bound_tightening`` makes the bounds narrower
with these rows, and the rows tighter with these bounds.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from synthesis.catalogue.constraints import MotionBox, SlideCoordinates, Vector
from synthesis.catalogue.followers.curvature_bound import CurvatureBound
from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic import tangent_cuts as cuts
from synthesis.optimise.conic.assembly import ConeBlock
from synthesis.optimise.conic.control import Control
from synthesis.optimise.conic.linear_rows import LinearBlock, Tightening
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.multiplier_density import PointRuns
from synthesis.optimise.problem.grid import Grid, SplineLaw
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.propagation.half_spaces import LOOSENING, HalfSpaces
from synthesis.optimise.propagation.point_bounds import PointBounds

APART = 0.05  # of a law, between nodes of the bounds
OPEN = 1e9  # strokes: nothing known
FAN, TURN = 24, 0.03  # tangents of a circle: most of them, and their step [rad]

Sizes = tuple[tuple[float, float], ...]
Parts = tuple[tuple[float, float], ...]


@dataclass(frozen=True, eq=False)
class TangentCam:
    """A cam about which rows shall be tight."""

    laws: tuple[SplineLaw, ...]
    size: Vector


@dataclass(frozen=True, eq=False)
class ImprovingRegion:
    """What every better cam of a box of sizes keeps to.

    Attributes:
        point_bounds: by position of the free law and the point that is seen.
        half_spaces: what all laws together leave of the size.
    """

    sizes: Sizes
    point_bounds: Mapping[tuple[int, SlideCoordinates], PointBounds]
    half_spaces: HalfSpaces
    reference: TangentCam | None = None

    @property
    def is_empty(self) -> bool:
        """Whether there is no such cam."""
        crossed = any(low > high for low, high in self.sizes)
        return crossed or any(bounds.is_empty for bounds in self.point_bounds.values())

    @property
    def is_divisible(self) -> bool:
        """Whether it has a size that is still open."""
        return any(high - low > LOOSENING * max(abs(low), abs(high)) for low, high in self.sizes)

    @property
    def mean_width(self) -> float:
        """How far the hulls are open, on average [length]."""
        return float(np.mean([bounds.width for bounds in self.point_bounds.values()] or [0.0]))

    def restrict(self, sizes: Sizes) -> ImprovingRegion:
        """The part of it in a box of sizes."""
        point_bounds = {
            key: replace(bounds, offsets=key[1].offset_range(sizes))
            for key, bounds in self.point_bounds.items()
        }
        return replace(self, sizes=sizes, point_bounds=point_bounds)

    def for_laws(self, positions: Sequence[int]) -> ImprovingRegion:
        """What it says of some laws, numbered anew."""
        point_bounds = {
            (number, coordinates): bounds
            for number, position in enumerate(positions)
            for coordinates, bounds in self.bounds_of_law(position)
        }
        reference = self.reference
        if reference is not None:
            reference = TangentCam(
                tuple(reference.laws[position] for position in positions), reference.size
            )
        return replace(self, point_bounds=point_bounds, reference=reference)

    def bounds_of_law(self, position: int) -> list[tuple[SlideCoordinates, PointBounds]]:
        """Of one law, by the point that is seen."""
        return [
            (coordinates, bounds)
            for (law, coordinates), bounds in self.point_bounds.items()
            if law == position
        ]

    def rows(self, model: ConicModel, *, sparing: bool = False) -> list[LinearBlock]:
        """Rows that limits imply along the hulls: tight in the middle, and at the guess.

        ``sparing``: at the guess alone, where there is one: multipliers of two rows that say
        nearly the same at a knot alternate, and the bound pays for it.
        """
        return [
            block
            for (position, _), implied, bounds in self._traced_limits(model.problem)
            for block in self._blocks(
                model,
                position,
                implied,
                bounds,
                _row_points(bounds, model, position),
                sparing=sparing,
            )
        ]

    def rows_between(
        self, model: ConicModel, each: int, *, sparing: bool = False
    ) -> list[tuple[LinearBlock, PointRuns]]:
        """The same rows between the points where they are written, too.

        ``each``: points between two of these.
        """
        result = list[tuple[LinearBlock, PointRuns]]()
        for (position, _), implied, bounds in self._traced_limits(model.problem):
            arc = PointRuns.of(_row_points(bounds, model, position), bounds.parts, each)
            written = self._blocks(
                model, position, implied, bounds, arc.points, bare=True, sparing=sparing
            )
            result += [(block, arc) for block in written]
        return result

    def _traced_limits(
        self, problem: Problem
    ) -> Iterator[tuple[tuple[int, SlideCoordinates], CurvatureBound, PointBounds]]:
        for position, segment in enumerate(problem.free):
            for limit in problem.limits:
                for implied in limit.curvature_bounds(segment, problem.machine):
                    key = position, implied.coordinates
                    if key in self.point_bounds:
                        yield key, implied, self.point_bounds[key]

    def _blocks(
        self,
        model: ConicModel,
        position: int,
        implied: CurvatureBound,
        bounds: PointBounds,
        x: Array,
        *,
        bare: bool = False,
        sparing: bool = False,
    ) -> Iterator[LinearBlock]:
        segment, grid = model.problem.free[position], Grid(model.grids[position].space, x)
        low, high = bounds.at(x)
        near = self._tangent_at(position, segment, implied.coordinates, x)
        for about in near if sparing and near else (None, *near):
            moving = self._motion_bounds(
                segment, implied, bounds, x, None if about is None else about[3:]
            )
            result = implied.relax(low, high, None if about is None else about[:3], moving)
            if result is not None:
                yield cuts.cut_block(
                    result,
                    implied.source,
                    position,
                    segment,
                    grid,
                    model.scales,
                    Tightening(),
                    bare=bare,
                )

    def _tangent_at(
        self, position: int, segment: PlacedSegment, coordinates: SlideCoordinates, x: Array
    ) -> list[Array]:
        """X, u and e, s, s' and s'' of the guess: (6, n); nothing where there is none."""
        if self.reference is None:
            return []
        law = self.reference.laws[position].curve()
        s = [segment.lift / segment.angle**k * law(x, k) for k in range(3)]
        s[0] = segment.s_start + s[0]
        return [np.stack([*coordinates.evaluate(s, self.reference.size), *s])]

    def _motion_bounds(
        self,
        segment: PlacedSegment,
        implied: CurvatureBound,
        bounds: PointBounds,
        x: Array,
        about: Array | None,
    ) -> MotionBox | None:
        """What hulls say of the motion itself, to rows that ask for it."""
        if not implied.needs_motion_bounds:
            return None
        low, high = (
            np.stack([*ends, bend])
            for ends, bend in zip(
                implied.coordinates.motion_bounds(*bounds.at(x), self.sizes),
                bounds.acceleration_bounds(x),
                strict=True,
            )
        )
        assert segment.free is not None
        if not segment.free.overshoot:
            least, most = sorted((segment.s_start, segment.s_end))
            low[0], high[0] = np.clip(low[0], least, most), np.clip(high[0], least, most)
        return MotionBox(segment.start + segment.angle * x, low, high, about)


def initial_region(
    problem: Problem, controls: Sequence[Control], parts: Mapping[int, Parts]
) -> ImprovingRegion:
    """All that the problem allows; hulls with nodes all over the parts of the free laws."""
    sizes = problem.sizing.bounds
    point_bounds = {}
    for position, ranges in parts.items():
        segment, cap = problem.free[position], controls[position].cap
        assert segment.free is not None
        nodes = np.concatenate(
            [np.linspace(a, b, 1 + max(2, int(np.ceil((b - a) / APART)))) for a, b in ranges]
        )
        known = dict[SlideCoordinates, int]()  # how many of X, u and s'' are asked for
        for limit in problem.limits:
            for implied in limit.curvature_bounds(segment, problem.machine):
                count = 3 if implied.needs_motion_bounds else 2
                known[implied.coordinates] = max(count, known.get(implied.coordinates, 0))
        for coordinates, rows in known.items():
            wide = np.full((rows, len(nodes)), OPEN * problem.length)
            sense = 0 if segment.free.overshoot else int(np.sign(segment.lift)) * coordinates.sign
            bend = abs(segment.lift) / segment.angle**3 * cap
            point_bounds[position, coordinates] = PointBounds(
                nodes,
                ranges,
                segment.angle,
                bend,
                sense,
                -wide,
                wide,
                coordinates.offset_range(sizes),
            )
    return ImprovingRegion(sizes, point_bounds, HalfSpaces.empty(len(sizes)))


def cone_tangents(model: ConicModel, cone: ConeBlock, sizes: Sizes) -> Iterator[LinearBlock]:
    """Tangents of a cone on the size, all round where sizes of the box may lie on it."""
    if cone.bound_column is not None or cone.norm is None:
        return
    matrix = cone.matrix[:, model.size]
    corners = np.stack(np.meshgrid(*(np.array(ends) for ends in sizes)), axis=-1)
    images = corners.reshape(-1, len(sizes)) / model.scales.size @ matrix.T + cone.shift
    if images.shape[1] == 2:
        middle = np.mean(images, axis=0)
        main = np.arctan2(*middle)
        off = np.arctan2(*images.T) - main
        off = (off + np.pi) % (2.0 * np.pi) - np.pi
        steps = min(int(np.ceil(np.ptp(off) / TURN)) + 1, FAN)
        angles = main + np.linspace(np.min(off), np.max(off), steps)
        directions = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    else:
        norms = np.linalg.norm(images, axis=1)
        directions = images[norms > 0.0] / norms[norms > 0.0, None]
    for y in directions:
        yield LinearBlock.of_size(y @ matrix, np.array([cone.radius - y @ cone.shift]), cone.source)


def _row_points(bounds: PointBounds, model: ConicModel, position: int) -> Array:
    """Where rows are written along a bounds: at every knot, so that each has a say of its own."""
    breaks = model.grids[position].space.breaks
    inside = [(low <= breaks) & (breaks <= high) for low, high in bounds.parts]
    return np.asarray(breaks[np.any(inside, axis=0)])
