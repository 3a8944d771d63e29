"""Self-intersection of a flank, in ball arithmetic: no roller position may reach into another part.

O(θ) is the flank, P(φ) the roller's centre, both on the cam, R the roller's radius. Where the
tangent turns by less than π along one of the two arcs of P between θ and φ, the limit on the
flank's curvature excludes an intersection (proof in ``certify/roller_interference.py``). Every
other pair of boxes must be at least R apart; pairs that are nearer are bisected.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import compress, pairwise, product
from typing import Final

import numpy as np
from flint import arb, arb_series

from synthesis.catalogue.followers.kinematics import Flank, Tip
from synthesis.certify.second import Remeasured
from synthesis.certify.second.exact_design import ExactDesign, remeasured
from synthesis.certify.second.exact_motion import (
    MotionPiece,
    SeriesVector,
    coefficient,
    hull,
    middle_of,
)
from synthesis.certify.second.quantities import LinkState, TipContact, cam_rate, cross, dot
from synthesis.design.design import Extreme
from synthesis.numerics.box_search import BoxSearch, Budget
from synthesis.numerics.piecewise import Array, Mask

WIDEST: Final = 0.06  # of a first box [rad]
LARGEST_TURNING: Final = 0.5  # a box over which the tangent turns by more is bisected [rad]
NARROWEST: Final = 1e-9  # a box is not bisected below this part of its segment
HARMLESS_DEPTH: Final = arb("1e-9")  # of the roller: interference of so little depth is none
HEADING_ROUNDING: Final = 1e-6  # of headings summed up in floating point [rad]
BUDGET: Final = Budget(levels=13, boxes=16_000, total=False)  # of pairs, 16,000 on a level
EDGE_PARTS: Final = 64  # parts of the stroke on which a knife edge is examined

Point = tuple[arb, arb]


def measure_self_intersection(design: ExactDesign, extreme: Extreme) -> Remeasured:
    """Whether a flank intersects itself: 0 where it is proven that it does not."""
    name = extreme.limit.removeprefix("self_crossing").removeprefix("_")
    flank = next(f for f in design.machine.follower.flanks if f.name == name)
    if flank.distance == 0.0:
        clear, how = _edge_is_clear(design, flank), "the edge's distance is monotone in s"
    else:
        clear, how = _FlankSearch(design, flank).is_clear(), "pairs of boxes in ball arithmetic"
    if clear is None:
        return remeasured(extreme)
    value = arb(0) if clear else None
    return remeasured(extreme, value, value, clear, clear == extreme.holds, how)


def _edge_is_clear(design: ExactDesign, flank: Flank) -> bool | None:
    """Whether a knife edge's distance from the axis is strictly monotone in s."""
    tip = _tip(design, flank)
    signs = set()
    for part in range(EDGE_PARTS):
        low, high = (design.motion.highest * k / EDGE_PARTS for k in (part, part + 1))
        displacement = arb_series([hull(low.lower(), high.upper()), 1])
        x, y = LinkState(design.link, displacement).position_of(tip.at)
        growth = coefficient(dot((x, y), (x.derivative(), y.derivative())), 0)
        signs.add(1 if growth > 0 else -1 if growth < 0 else 0)
    return True if signs in ({1}, {-1}) else None


def _tip(design: ExactDesign, flank: Flank) -> Tip:
    return next(tip for tip in design.link.tips if tip.path == flank.path)


@dataclass(frozen=True, eq=False)
class _Box:
    """A part of a piece: enclosures of roller centre and flank on the cam.

    ``low`` and ``high`` bound x. ``heading``: the tangent's angle on the cam at both ends [rad];
    ``turning``: how far it can turn to either side of these [rad].
    """

    piece: MotionPiece
    low: arb
    high: arb
    centre: Point
    flank: Point
    heading: tuple[float, float]
    turning: float


Pairs = list[tuple[_Box, _Box]]  # the flank over the first, the roller's centre over the second


class _FlankSearch(BoxSearch[Pairs]):
    """The box search for interference of one flank with its roller: near pairs stay open."""

    children = 4

    def __init__(self, design: ExactDesign, flank: Flank) -> None:
        self.link, self.tip = design.link, _tip(design, flank)
        self.distance = arb(flank.side * flank.distance)
        self.least = arb(flank.distance) * (1 - HARMLESS_DEPTH)
        self.motion = design.motion
        self.halves: dict[_Box, tuple[_Box, _Box]] = {}
        self.interferes = False

    def is_clear(self) -> bool | None:
        """Whether every far pair is far enough apart; None if undecided."""
        boxes = [box for piece in self.motion.pieces for box in self._boxes_of(piece)]
        decided = self.run([(boxes[i], boxes[j]) for i, j in _far_pairs(boxes)], BUDGET)
        return False if self.interferes else True if decided else None

    def bound(self, boxes: Pairs) -> Array:
        """1 for a pair that may be nearer than the roller's radius, −1 for the others.

        A roller at the middle of its box that reaches into the flank at the middle of the other is
        an interference for certain.
        """
        found = np.full(len(boxes), -1.0)
        for k, (a, b) in enumerate(boxes):
            if not self._is_apart(a.flank, b.centre):
                found[k] = 1.0
                square = _squared_distance(self._middle(a).flank, self._middle(b).centre)
                if square < self.least * self.least:
                    self.interferes = True
                    break
        return found

    def threshold(self) -> float:
        """0, or with an interference ∞: then the search is over."""
        return math.inf if self.interferes else 0.0

    def split(self, boxes: Pairs, keep: Mask) -> Pairs:
        near = compress(boxes, keep.tolist())
        return [pair for a, b in near for pair in product(self._halves(a), self._halves(b))]

    def _is_apart(self, flank: Point, centre: Point) -> bool:
        """Whether a part of the flank keeps its distance from the roller's centre."""
        return bool(_squared_distance(flank, centre).lower() >= self.least * self.least)

    def _middle(self, box: _Box) -> _Box:
        middle = middle_of(box.low, box.high)
        return self._box(box.piece, middle, middle)

    def _halves(self, box: _Box) -> tuple[_Box, _Box]:
        if box not in self.halves:
            middle = middle_of(box.low, box.high)
            one = self._box(box.piece, box.low, middle)
            self.halves[box] = one, self._box(box.piece, middle, box.high)
        return self.halves[box]

    def _boxes_of(self, piece: MotionPiece) -> Iterator[_Box]:
        """Boxes along one piece, narrow enough and with little turning of the tangent."""
        width = float((piece.law.high - piece.law.low) * piece.angle)
        count = max(math.ceil(width / WIDEST), 1)
        step = (piece.law.high - piece.law.low) / count
        ends = [piece.law.low.mid(), *((piece.law.low + k * step).mid() for k in range(1, count))]
        open_parts = list(pairwise([*ends, piece.law.high]))[::-1]
        while open_parts:
            low, high = open_parts.pop()
            box = self._box(piece, low, high)
            if box.turning <= LARGEST_TURNING or float(high - low) < NARROWEST:
                yield box
                continue
            middle = middle_of(low, high)
            open_parts += [(middle, high), (low, middle)]

    def _box(self, piece: MotionPiece, low: arb, high: arb) -> _Box:
        x = hull(low, high)
        contact = self._contact(piece, x)
        tangent = cam_rate(contact.curve)
        square = dot(tangent, tangent)
        # over too wide a box the tangent might vanish, or the bound be no number
        if not coefficient(square.sqrt(), 0).lower() > 0:
            unknown = arb(0, arb.pos_inf())
            places = (unknown, unknown), (unknown, unknown)
            return _Box(piece, low, high, *places, (0.0, 0.0), math.inf)
        # rate at which the tangent turns on the cam, counter-clockwise, times the width
        swept = coefficient(cross(tangent, cam_rate(tangent)) / square, 0)
        turning = float((abs(swept) * (high - low) * piece.angle).upper())
        ends = (self._heading(piece, low), self._heading(piece, high))
        return _Box(piece, low, high, *self._places(piece, x, contact), ends, turning)

    def _contact(self, piece: MotionPiece, x: arb) -> TipContact:
        return TipContact(LinkState(self.link, piece.displacement(x)), self.tip)

    def _heading(self, piece: MotionPiece, x: arb) -> float:
        """The tangent's angle on the cam [rad].

        In floating point: a ball across the cut of the arc tangent could be anywhere.
        """
        tx, ty = cam_rate(self._contact(piece, x).curve)
        heading = math.atan2(float(coefficient(ty, 0)), float(coefficient(tx, 0)))
        return heading - float(piece.angle_at(x))

    def _places(self, piece: MotionPiece, x: arb, contact: TipContact) -> tuple[Point, Point]:
        """Roller centre and flank on the cam over x: mean value form about the middle."""
        middle = x.mid()
        at_middle = self._contact(piece, middle)
        reach = (x - middle) * piece.angle
        found = []
        for here, over in zip(self._both(at_middle), self._both(contact), strict=True):
            shift = [coefficient(part, 0) * reach for part in cam_rate(over)]
            point = (coefficient(here[0], 0), coefficient(here[1], 0))
            fixed = _on_cam(point, piece.angle_at(middle))
            # components of the rate are in the machine frame, which turns by up to the reach
            moved = _on_cam((shift[0], shift[1]), piece.angle_at(x))
            found.append((fixed[0] + moved[0], fixed[1] + moved[1]))
        return found[0], found[1]

    def _both(self, contact: TipContact) -> tuple[SeriesVector, SeriesVector]:
        """P and O = P − D n in the machine frame."""
        (x, y), (nx, ny) = contact.curve, contact.normal
        length = dot(contact.normal, contact.normal).sqrt()
        return contact.curve, (x - nx / length * self.distance, y - ny / length * self.distance)


def _squared_distance(one: Point, other: Point) -> arb:
    return sum(((a - b) ** 2 for a, b in zip(one, other, strict=True)), arb(0))


def _on_cam(vector: Point, angle: arb) -> Point:
    """A vector of the machine frame in the frame of a cam that has turned by an angle."""
    (x, y), cos, sin = vector, angle.cos(), angle.sin()
    return x * cos + y * sin, y * cos - x * sin


def _far_pairs(boxes: Sequence[_Box]) -> Iterator[tuple[int, int]]:
    """Pairs of boxes along both arcs between which the tangent may turn by π or more."""
    # range of the heading on every box, continued over two turns so that every arc is contiguous
    count, at, last = len(boxes), 0.0, boxes[-1].heading[1]
    low, high = np.zeros((2, 2 * count))
    for k, box in enumerate([*boxes, *boxes]):
        at += _turn(last, box.heading[0])  # at corners only
        end = at + _turn(*box.heading)
        low[k] = min(at, end) - box.turning - HEADING_ROUNDING
        high[k] = max(at, end) + box.turning + HEADING_ROUNDING
        at, last = end, box.heading[1]
    # arcs that start at box i and over which the range stays below π
    index = np.arange(count)
    near = np.zeros((count, count), dtype=bool)
    for i in range(count):
        spread = np.maximum.accumulate(high[i : i + count])
        spread = spread - np.minimum.accumulate(low[i : i + count])
        near[i, (index + i) % count] = spread < math.pi
    rows, columns = np.nonzero(~(near | near.T))
    yield from zip(rows.tolist(), columns.tolist(), strict=True)


def _turn(before: float, after: float) -> float:
    """From one heading to the next, by at most half a turn."""
    return math.remainder(after - before, 2.0 * math.pi)
