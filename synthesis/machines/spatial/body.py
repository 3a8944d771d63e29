"""The cam as a body: a turned blank with all grooves cut, as a grid over the turn and as a mesh.

The blank is a hub, and a rim from the ribs' tops to the grooves' floor. A half-plane through the
axis cuts the body in one closed outline: out along the lower face, over ribs and through grooves,
back along the upper face and down the bore. All outlines have the same columns of points. Where a
groove lies outside of the blank its walls lie on the blank's end, so that ribs begin and end there;
what such walls enclose has no volume.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from synthesis.errors import InputError
from synthesis.exporters.options import BoreDiameter, Options
from synthesis.machines.spatial.grooves import GrooveSections, shifted
from synthesis.numerics.geometry.charts import Chart
from synthesis.numerics.geometry.swept_roller import cross, dot, norm
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

Whole = NDArray[np.int64]
MIN_RIB = 1e-5  # of the blank's width: least width of a rib that would end in a point
SAMPLED_ROWS = 90  # at which the body is compared with the true surface
END_MARGIN = 2.0  # roller radii from the last axis to the end: leaves one radius of material
RIM_ANGLES = np.linspace(0.0, FULL_TURN, 16, endpoint=False)
Spacing = Callable[[float, float, int], Array]
Clearance = Annotated[float, Field(ge=0.0, le=1e4)]


@dataclass(frozen=True, kw_only=True)
class BlankOptions(Options):
    """The body that the grooves are cut into."""

    bore_mm: BoreDiameter = None
    width_mm: Annotated[float | None, Field(gt=0.0, le=1e5)] = None
    """Width between two flat ends at equal distances from the common perpendicular; left out: the
    cam's own, or as far as the rollers mesh, or one roller radius beyond their grooves."""
    tip_clearance_mm: Clearance = 0.0
    """Clearance between the ribs' tops and the rollers' inner ends."""
    end_clearance_mm: Clearance = 1.0
    """Clearance between the grooves' floor and the rollers' outer ends."""


@dataclass(frozen=True, eq=False)
class Blank:
    """The body before grooves are cut, in the coordinates of a chart.

    At every ``depth`` (m,) from the ribs' tops to the floor its two ends are at the places across
    ``low`` and ``high``. ``bore`` is the radius of the bore [mm]; 0: none.
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
        bore, floor = 0.5 * (options.bore_mm or 0.0), np.linspace(low[-1], high[-1], 181)
        thin = float(np.min(cuts.chart.meridian(depth[-1:], floor)[0]))
        if thin <= 0.0:
            raise InputError(
                "/end_clearance_mm", options.end_clearance_mm,
                f"The grooves' floor reaches {-thin:.6g} mm beyond the cam's axis: with these "
                "rollers and this centre distance nothing is left of the body.",
                "Reduce the clearance, increase the centre distance, or use shorter rollers.",
            )  # fmt: skip
        if thin <= bore:
            raise InputError(
                "/bore_mm", options.bore_mm,
                f"The grooves' floor is {thin:.6g} mm from the cam's axis.",
                f"Choose a diameter below {2.0 * thin:.6g} mm.",
            )  # fmt: skip
        return cls(cuts.chart, depth, low, high, bore)


def _depth_range(cuts: GrooveSections) -> tuple[float, float]:
    """Depth of the ribs' tops, and the largest depth of the rollers' rims [mm]."""
    roller, velocity = cuts.cam.swept.roller, cuts.cam.swept.joint.velocity_per_q
    u = cuts.directions()
    ends = np.array([roller.inner, roller.outer])
    deepest = [*cuts.chart.depth_of_place(ends)]
    for rho, radius in zip(ends, roller.profile(ends)[0], strict=True):
        axis = cuts.axes(rho)
        one = velocity(axis) - dot(velocity(axis), u) * u
        one = one / norm(one)
        rim = axis + radius * (np.cos(RIM_ANGLES) * one + np.sin(RIM_ANGLES) * cross(u, one))
        deepest += [np.max(cuts.to_chart(axis)[1]), np.max(cuts.to_chart(rim)[1])]
    return float(min(cuts.chart.depth_of_place(ends))), float(max(deepest))


@dataclass(frozen=True)
class Strip:
    """Neighbouring columns that make one smooth part of the surface.

    Attributes:
        kind: wall, top, floor, face or bore.
        first, last: columns, both included. rising: whether they go from the floor to a top.
    """

    kind: str
    first: int
    last: int
    rising: bool = False


@dataclass(frozen=True, eq=False)
class Body:
    """A body as outlines over its turn.

    Attributes:
        blank: from which it is cut.
        turn: (n + 1,) rows, cam angles at which they face the follower; the last is the first.
        kept: the grooves that it has.
        ribs: (2, k + 1, n + 1, m) places across of the two walls of each rib, by depth.
        radius, height: (n + 1, c) points of the outlines [mm].
        strips: kinds of the columns. hand: sense of the rows around the axis.
    """

    blank: Blank
    turn: Array
    kept: slice
    ribs: Array
    radius: Array
    height: Array
    strips: tuple[Strip, ...]
    hand: int

    @property
    def points(self) -> Array:
        """(3, n + 1, c) of the cam's frame [mm]."""
        at = -self.hand * (self.turn[:, None] % FULL_TURN)
        return np.stack([self.radius * np.cos(at), self.radius * np.sin(at), self.height])


def build_body(cuts: GrooveSections, blank: Blank, rows: int, parts: int | None = None) -> Body:
    """The body with so many rows; lines across in so many flat parts, None: as its chart needs.

    Raises:
        InputError: as ``GrooveSections.grooves``.
    """
    turn = np.linspace(0.0, FULL_TURN, rows + 1)
    walls, shift = cuts.grooves(turn[:-1], blank.depth)
    # Grooves at either side that never meet the blank are left out.
    met = np.any((walls[1] > blank.low) & (walls[0] < blank.high), axis=(1, 2))
    kept = slice(int(np.argmax(met)), len(met) - int(np.argmax(met[::-1])))
    # The first row is repeated as the last, where each groove has become another.
    missing = np.inf if shift > 0 else -np.inf
    after = [shifted(each[kept, :1], shift, missing) for each in walls]
    ribs = rib_bounds(blank, np.concatenate([walls[:, kept], after], axis=2))
    radius, height, strips = _outline(blank, ribs, blank.chart.parts if parts is None else parts)
    return Body(blank, turn, kept, ribs, radius, height, strips, cuts.cam.swept.hand)


def rib_bounds(blank: Blank, grooves: Array) -> Array:
    """Both walls of the ribs (2, k + 1, n, m): between grooves (2, k, n, m), within the blank."""
    low, high = grooves
    first, last = (np.broadcast_to(end, low[:1].shape) for end in (blank.low, blank.high))
    starts = np.clip(np.concatenate([first, high]), blank.low, blank.high)
    ends = np.clip(np.concatenate([low, last]), blank.low, blank.high)
    gone = starts > ends
    middle = 0.5 * (starts + ends)
    starts, ends = np.where(gone, middle, starts), np.where(gone, middle, ends)
    if len(blank.depth) < 2:
        return np.stack([starts, ends])
    # What is left of a rib beside a flat end may overhang the floor: keep a least width at its
    # foot, as a solid must not touch itself in a line.
    hung = (starts[..., -1] == ends[..., -1]) & (starts[..., -2] < ends[..., -2])
    below = hung & (starts[..., -1] > blank.low[-1])
    width = MIN_RIB * (blank.high[-1] - blank.low[-1])
    starts[..., -1] -= np.where(below, width, 0.0)
    ends[..., -1] += np.where(hung & ~below, width, 0.0)
    return np.stack([starts, ends])


def flank_error(cuts: GrooveSections, body: Body) -> float:
    """Largest distance of walls and circles from the body's flat cells, at their middles [mm]."""
    blank, rows = body.blank, len(body.turn) - 1
    step = FULL_TURN / rows
    sampled = np.arange(0, rows, max(1, rows // SAMPLED_ROWS))
    depth = 0.5 * (blank.depth[1:] + blank.depth[:-1])
    walls, _ = cuts.grooves(body.turn[sampled] + 0.5 * step, depth)
    low, high = (0.5 * (each[1:] + each[:-1]) for each in (blank.low, blank.high))
    between = Blank(blank.chart, depth, low, high, blank.bore)
    true = rib_bounds(between, walls[:, body.kept])
    # The corners of all cells that lie wholly on a rib within the blank.
    steps = [(i, slice(j, len(depth) + j)) for i in (0, 1) for j in (0, 1)]
    corners = np.stack([body.ribs[:, :, sampled + i][..., each] for i, each in steps])
    inside = (corners > np.max(blank.low)) & (corners < np.min(blank.high))
    whole = np.all(inside & (corners[:, :1] < corners[:, 1:]), axis=0)
    cell = [
        blank.chart.points(np.array(i * step), blank.depth[each], corner)
        for (i, each), corner in zip(steps, corners, strict=True)
    ]
    # Along the cell's normal, from its middle to the true surface in the middle row and depth.
    normal = cross(cell[3] - cell[0], cell[2] - cell[1])
    middle = blank.chart.points(np.array(0.5 * step), depth, true)
    with np.errstate(invalid="ignore"):
        away = np.abs(dot(np.mean(cell, axis=0) - middle, normal)) / norm(normal)
    chord = float(np.max(body.radius)) * (1.0 - math.cos(0.5 * step))
    wide = blank.chart.sag(blank.depth, (body.ribs[1] - body.ribs[0]).max(axis=(0, 1)))
    return max(chord, float(np.max(wide)), float(np.max(away, where=whole, initial=0.0)))


def _outline(blank: Blank, ribs: Array, parts: int) -> tuple[Array, Array, tuple[Strip, ...]]:
    """Radius and height (n, c) of all columns, from the lower face to the upper; their strips."""
    up, down, share = blank.depth[::-1], blank.depth, np.arange(1, parts) / parts

    def between(kind: str, start: Array, end: Array, depth: float) -> tuple[str, Array, Array]:
        """Columns between two walls, of which the strip has one column each."""
        place = start[:, None] + (end - start)[:, None] * share
        return kind, np.full(len(share), depth), place

    runs: list[tuple[str, Array, Array]] = []  # kind, depth (c,) and place across (n, c)
    for k, (start, end) in enumerate(zip(*ribs, strict=True)):
        if k:
            runs.append(between("floor", ribs[1][k - 1, :, -1], start[:, -1], float(down[-1])))
        runs.append(("wall", up, start[:, ::-1]))
        runs.append(between("top", start[:, 0], end[:, 0], float(down[0])))
        runs.append(("wall", down, end))
    # The bore is column 0. Of four runs one is a wall that rises.
    counts = np.cumsum([1, *(len(depth) for _, depth, _ in runs)]).tolist()
    strips = [
        Strip(kind, a, b - 1, k % 4 == 0) if kind == "wall" else Strip(kind, a - 1, b)
        for k, ((kind, _, _), (a, b)) in enumerate(zip(runs, pairwise(counts), strict=True))
    ]
    place = np.concatenate([place for _, _, place in runs], axis=1)
    depth = np.concatenate([depth for _, depth, _ in runs])
    radius, height = blank.chart.meridian(np.broadcast_to(depth, place.shape), place)
    # The hub: a column of the bore at either end; the outline closes through the bore.
    last, bore = counts[-1], np.full((len(radius), 1), blank.bore)
    hub = [Strip("face", 0, 1), *strips, Strip("face", last - 1, last), Strip("bore", last, 0)]
    faces = blank.chart.meridian(down[-1:], np.array([blank.low[-1], blank.high[-1]]))[1]
    low, high = (np.full_like(bore, face) for face in faces)
    return np.hstack([bore, radius, bore]), np.hstack([low, height, high]), tuple(hub)


@dataclass(frozen=True, eq=False)
class Mesh:
    """A closed surface.

    Attributes:
        points: (n, 3) [mm]. triangles: (k, 3) points of each, counter-clockwise seen from outside.
            No two points are the same in single precision.
    """

    points: Array
    triangles: Whole

    @cached_property
    def corners(self) -> tuple[Array, Array, Array]:
        """Points of the triangles' corners, (k, 3) each."""
        a, b, c = self.points[self.triangles.T]
        return a, b, c

    @property
    def normals(self) -> Array:
        """(k, 3) outward normals, of twice the triangles' areas."""
        a, b, c = self.corners
        return np.asarray(np.cross(b - a, c - a))

    @property
    def volume(self) -> float:
        """Enclosed volume [mm³], by the divergence theorem."""
        a, b, c = self.corners
        return float(np.sum(a * np.cross(b, c)) / 6.0)


def triangulate(body: Body) -> Mesh:
    """The body's surface."""
    # Distinct points, and the number of each grid point among them: (n + 1, c). They are compared
    # in single precision, as files store them.
    points = body.points.astype(np.float32).reshape(3, -1) + np.float32(0.0)
    distinct, numbers = np.unique(points, axis=1, return_inverse=True)
    numbers = numbers.reshape(body.radius.shape)
    # Two triangles a cell; in walls the diagonal is the same for columns up and down, so that two
    # walls in one place cancel, triangle by triangle.
    triangles = []
    for strip in body.strips:
        columns = [*range(strip.first, strip.last + 1)] or [strip.first, strip.last]
        grid = numbers[:, columns]
        here, beside = grid[:-1, :-1], grid[:-1, 1:]
        after, across = grid[1:, :-1], grid[1:, 1:]
        corners = (
            [(here, beside, across), (here, across, after)]
            if strip.rising
            else [(here, beside, after), (beside, across, after)]
        )
        triangles += [np.stack(each, axis=-1).reshape(-1, 3) for each in corners]
    mesh = Mesh(distinct.T.astype(float), _cancel_folds(np.concatenate(triangles)))
    return mesh if mesh.volume > 0.0 else replace(mesh, triangles=mesh.triangles[:, ::-1])


def _cancel_folds(triangles: Whole) -> Whole:
    """Without degenerate triangles, and without pairs that lie back to back."""
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    order = np.argsort(triangles, axis=1)
    sorted_ = np.take_along_axis(triangles, order, axis=1)
    even = (order[:, 1] - order[:, 0]) % 3 == 1
    _, first, which = np.unique(sorted_, axis=0, return_index=True, return_inverse=True)
    net = np.bincount(which.ravel(), weights=np.where(even, 1.0, -1.0))
    kept = np.flatnonzero(net)
    triangles = sorted_[first[kept]]
    return np.where(net[kept, None] > 0, triangles, triangles[:, ::-1])
