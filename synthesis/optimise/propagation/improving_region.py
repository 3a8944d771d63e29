"""The improving region: bounds of the size and of the traced point of every better cam.

A limit on curvature or on Hertz pressure speaks of the point that traces a curve: its height X and
its speed past the axis u = X' − e. Within bounds of (X, u, e) the limit implies linear rows
(``rows``; McCormick's estimators, in the catalogue). ``bound_tightening`` makes the bounds narrower
with these rows, and the rows tighter with these bounds.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from synthesis.catalogue.box_bounds import BoxBound
from synthesis.catalogue.constraints import MotionBox, SlideCoordinates, Vector
from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic import tangent_cuts as cuts
from synthesis.optimise.conic.control import Control
from synthesis.optimise.conic.linear_rows import LinearBlock, Tightening
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.multiplier_density import PointRuns
from synthesis.optimise.problem.grid import Grid
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.propagation.half_spaces import LOOSENING, HalfSpaces
from synthesis.optimise.propagation.point_bounds import PointBounds

NODE_DISTANCE = 0.05  # of a law, at first
UNBOUNDED = 1e9  # strokes
FARTHER = 10.0  # largest sizes: no cam's point is so far away or so fast past the axis

Sizes = tuple[tuple[float, float], ...]
Parts = tuple[tuple[float, float], ...]


@dataclass(frozen=True, eq=False)
class ImprovingRegion:
    """What every better cam of a box of sizes keeps to.

    Attributes:
        point_bounds: by position of the free law and the point that is seen.
        half_spaces: what all laws together leave of the size.
        reference: a cam about which rows shall be tight.
        binding: free laws and numbers of the limits whose rows are written on them; None: all.
            Others would cost knots and gain nothing.
    """

    sizes: Sizes
    point_bounds: Mapping[tuple[int, SlideCoordinates], PointBounds]
    half_spaces: HalfSpaces
    reference: cuts.TangentPoint | None = None
    binding: frozenset[tuple[int, int]] | None = None

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
        """How far the point's bounds are apart, on average [length]."""
        return float(np.mean([bounds.width for bounds in self.point_bounds.values()] or [0.0]))

    @property
    def widest_size(self) -> float:
        """The widest range of a size in which cams do not grow."""
        return max(high - low for low, high in (self.sizes[:-1] or self.sizes))

    def widened(self, by: float) -> ImprovingRegion:
        """With sizes that are open by so much more to every side [length], its laws as they are."""
        if not by:
            return self
        sizes = tuple((a - by, b + by) if a < b else (a, b) for a, b in self.sizes)
        planes = self.half_spaces
        # a step of ``by`` in every size lowers normal · z by its sum of absolute values
        offsets = planes.offsets - by * np.sum(np.abs(planes.normals), axis=1)
        return replace(self.restrict(sizes), half_spaces=replace(planes, offsets=offsets))

    def within(self, other: ImprovingRegion) -> ImprovingRegion:
        """With its sizes in those of another, which hold as well; itself where they lie there."""
        both = zip(self.sizes, other.sizes, strict=True)
        sizes = tuple((max(a, c), min(b, d)) for (a, b), (c, d) in both)
        if sizes == tuple(self.sizes):
            return self
        return replace(self.restrict(sizes), half_spaces=other.half_spaces)

    def restrict(self, sizes: Sizes) -> ImprovingRegion:
        """The part of it in a box of sizes."""
        point_bounds = {
            key: replace(bounds, offsets=key[1].offset_range(sizes))
            for key, bounds in self.point_bounds.items()
        }
        return replace(self, sizes=sizes, point_bounds=point_bounds)

    def with_closer_nodes(self, positions: Collection[int]) -> ImprovingRegion:
        """The same with nodes of some laws that lie as close as their bounds are narrow."""
        point_bounds = {
            key: bounds.with_closer_nodes() if key[0] in positions else bounds
            for key, bounds in self.point_bounds.items()
        }
        return replace(self, point_bounds=point_bounds)

    def with_parts(
        self, problem: Problem, controls: Sequence[Control], parts: Mapping[int, Parts]
    ) -> ImprovingRegion:
        """The same with rows on further parts of laws, where nothing is known of them yet."""
        point_bounds, wide = dict(self.point_bounds), _unbounded(problem)
        for key, bounds in initial_region(problem, controls, parts).point_bounds.items():
            known = point_bounds.get(key)
            point_bounds[key] = (
                replace(bounds, offsets=key[1].offset_range(self.sizes)) if known is None
                else known.with_parts(bounds.parts, NODE_DISTANCE, wide)
            )  # fmt: skip
        return replace(self, point_bounds=point_bounds)

    def for_laws(self, positions: Sequence[int]) -> ImprovingRegion:
        """What it says of some laws, numbered anew."""
        point_bounds = {
            (number, coordinates): bounds
            for number, position in enumerate(positions)
            for coordinates, bounds in self.bounds_of_law(position)
        }
        reference = self.reference
        if reference is not None:
            reference = replace(reference, laws=tuple(reference.laws[k] for k in positions))
        binding = self.binding
        if binding is not None:
            number = {position: k for k, position in enumerate(positions)}
            binding = frozenset((number[k], limit) for k, limit in binding if k in number)
        return replace(self, point_bounds=point_bounds, reference=reference, binding=binding)

    def bounds_of_law(self, position: int) -> list[tuple[SlideCoordinates, PointBounds]]:
        """Of one law, by the point that is seen."""
        return [
            (coordinates, bounds)
            for (law, coordinates), bounds in self.point_bounds.items()
            if law == position
        ]

    def rows(
        self, model: ConicModel, each: int, *, sparing: bool = False
    ) -> list[tuple[LinearBlock, LinearBlock, PointRuns | None]]:
        """Rows that limits imply within the bounds: tight in the middle, and at the reference.

        ``each``: points between two of the knots where they are written; none of rows without s'',
        whose multipliers at points serve the bound as well as densities. ``sparing``: those with
        s'' at the reference alone, where there is one: multipliers of two that say nearly the same
        at a knot alternate, and the bound pays for it.

        Returns:
            rows; the same between these points, too, for bounds over all laws; and these points.
        """
        result = list[tuple[LinearBlock, LinearBlock, PointRuns | None]]()
        for position, implied, bounds in self._traced_limits(model.problem):
            segment, breaks = model.problem.free[position], model.grids[position].space.breaks
            spans, runs = None, None
            if implied.order == bounds.order:
                # Of the control itself a value at a point says nothing: means over the knot
                # intervals inside the parts, as nothing is known beyond their ends.
                spans = np.stack([breaks[:-1], breaks[1:]], axis=1)
                inside = [(a <= spans[:, 0]) & (spans[:, 1] <= b) for a, b in bounds.parts]
                spans = spans[np.any(inside, axis=0)]
                if not len(spans):
                    continue
                x, (low, high) = spans.mean(axis=1), bounds.along(spans)
            else:
                # at every knot, so that each has a row of its own; more between where ψ jumps, else
                # at all points of the mesh
                jumps = implied.order == bounds.order - 1
                own = breaks if jumps else model.grids[position].points
                own = own[np.any([(a <= own) & (own <= b) for a, b in bounds.parts], 0)]
                points = PointRuns.of(own, bounds.parts, each if jumps else 0)
                x, (low, high) = points.points, bounds.at(points.points)
                runs = points if jumps else None
            grid = solved = Grid(model.grids[position].space, x)
            if runs is not None:
                solved = Grid(grid.space, x[runs.rows])
            near = list[tuple[Array, Vector]]()  # s, s' and s'' of the reference, and its size
            if self.reference is not None:
                near.append(self.reference.at(position, segment, x))
            for about in near if sparing and near and implied.order > 1 else (None, *near):
                traced = None if about is None else np.stack(implied.coordinates.evaluate(*about))
                motion = self._motion_bounds(segment, implied, bounds, x, (low, high), about)
                for cut in implied.linear_relaxation(low, high, traced, motion):
                    at_knots = cut if runs is None else cut.select(runs.rows)
                    block = cuts.cut_block(
                        at_knots, implied.source, position, segment, solved, model.scales,
                        Tightening(), spans,
                    )  # fmt: skip
                    denser = block
                    if runs is not None:
                        denser = cuts.cut_block(
                            cut, implied.source, position, segment, grid, model.scales,
                            Tightening(), bare=True,
                        )  # fmt: skip
                    result.append((block, denser, runs))
        return result

    def _traced_limits(self, problem: Problem) -> Iterator[tuple[int, BoxBound, PointBounds]]:
        for position, segment in enumerate(problem.free):
            for number, limit in enumerate(problem.limits):
                if self.binding is not None and (position, number) not in self.binding:
                    continue
                for implied in limit.box_bounds(segment, problem.machine):
                    bounds = self.point_bounds.get((position, implied.coordinates))
                    if bounds is not None and is_stated(implied, bounds.order):
                        yield position, implied, bounds

    def _motion_bounds(
        self,
        segment: PlacedSegment,
        implied: BoxBound,
        bounds: PointBounds,
        x: Array,
        point: tuple[Array, Array],
        about: tuple[Array, Vector] | None,
    ) -> MotionBox | None:
        """What is known of motion and size themselves, for rows that ask for it.

        ``point``: bounds of (X, u, e) there.
        """
        if not implied.needs_motion_bounds:
            return None
        low, high = (
            np.stack([*ends, bend])
            for ends, bend in zip(
                implied.coordinates.motion_bounds(*point, self.sizes),
                bounds.acceleration_bounds(x),
                strict=True,
            )
        )
        assert segment.free is not None
        if not segment.free.overshoot:
            least, most = sorted((segment.s_start, segment.s_end))
            low[0], high[0] = np.clip(low[0], least, most), np.clip(high[0], least, most)
        return MotionBox(segment.start + segment.angle * x, low, high, self.sizes, about)


def is_stated(implied: BoxBound, order: int) -> bool:
    """Whether a limit has rows where a derivative of some order is the control.

    Rows of the control hold along spans, and so say nothing of what changes along them.
    """
    return implied.order < order or not implied.varies_with_angle


def initial_region(
    problem: Problem, controls: Sequence[Control], parts: Mapping[int, Parts]
) -> ImprovingRegion:
    """All that the problem allows; bounds with nodes all over the parts of the free laws."""
    sizes, unbounded, point_bounds = problem.sizing.bounds, _unbounded(problem), {}
    for position, ranges in parts.items():
        segment, control = problem.free[position], controls[position]
        assert segment.free is not None
        counts = (1 + max(2, int(np.ceil((b - a) / NODE_DISTANCE))) for a, b in ranges)
        both = zip(ranges, counts, strict=True)
        nodes = np.concatenate([np.linspace(*ends, count) for ends, count in both])
        known = dict[SlideCoordinates, int]()  # how many of X, u and s'' are asked for
        for limit in problem.limits:
            for implied in limit.box_bounds(segment, problem.machine):
                before = known.get(implied.coordinates, 0)
                known[implied.coordinates] = max(min(implied.known_orders, control.order), before)
        for coordinates, rows in known.items():
            wide = np.full((rows, len(nodes)), unbounded)
            sense = 0 if segment.free.overshoot else int(np.sign(segment.lift)) * coordinates.sign
            unit = abs(segment.lift) / segment.angle**control.order
            point_bounds[position, coordinates] = PointBounds(
                nodes, ranges, segment.angle, control.order, unit * control.cap, sense, -wide, wide,
                coordinates.offset_range(sizes), unit**2 * segment.angle * control.square,
            )  # fmt: skip
    return ImprovingRegion(sizes, point_bounds, HalfSpaces.empty(len(sizes)))


def _unbounded(problem: Problem) -> float:
    """What no coordinate of a cam's traced point reaches [length]."""
    largest = max(abs(end) for ends in problem.sizing.bounds for end in ends)
    return max(UNBOUNDED * problem.length, FARTHER * largest)
