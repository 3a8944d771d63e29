"""That no position of a roller reaches into another part of its flank, in ball arithmetic.

O(θ) the flank, P(φ) the roller's centre, both on the cam, R the roller. Where along one of the two
arcs of P between θ and φ the tangent turns by less than π, the flank's curvature settles the matter
(``certify/self_crossing`` has the proof); every other pair is shown to be at least R apart, boxes
against boxes, first those of the whole turn, then parts of those that are too near.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from flint import arb, arb_series

from synthesis.confirmation.arithmetic import Pair, hull, term
from synthesis.confirmation.course import Piece
from synthesis.confirmation.quantities import TipContact, View, cross, dot, rate
from synthesis.confirmation.subject import NOTHING, Measured, Subject
from synthesis.design import Extreme
from synthesis.followers.flank import Flank
from synthesis.followers.link import Tip

WIDEST: Final = 0.06  # of a box [rad]
TURNING: Final = 0.5  # of the tangent over a box [rad]
TOUCHING: Final = arb("1e-9")  # of the roller: so deep a crossing counts as none
PADDING: Final = 1e-6  # rad: what is lost where headings are summed up in floating point
DEEPEST: Final = 12  # halvings of a pair that is too near
MOST_PAIRS: Final = 4_000  # of parts that are looked at where whole boxes are too near
EDGES: Final = 64  # parts of the stroke on which a knife edge is looked at

Place = tuple[arb, arb]


def crossing(subject: Subject, extreme: Extreme) -> Measured:
    """Whether a flank crosses itself: 0 where it is shown that it does not."""
    name = extreme.limit.removeprefix("self_crossing").removeprefix("_")
    flank = next(f for f in subject.machine.follower.flanks if f.name == name)
    clear = _edge(subject, flank) if flank.distance == 0.0 else _Flank(subject, flank).clear()
    if clear is None:
        return NOTHING
    how = "pairs of boxes in balls" if flank.distance else "the edge moves one way with s"
    value = arb(0) if clear else None
    return Measured(value, value, clear, clear == extreme.holds, how)


def _edge(subject: Subject, flank: Flank) -> bool | None:
    """A knife edge: whether its distance from the axis changes one way with s throughout."""
    tip = _tip(subject, flank)
    signs = set()
    for part in range(EDGES):
        low, high = (subject.course.highest * k / EDGES for k in (part, part + 1))
        moved = arb_series([hull(low.lower(), high.upper()), 1])
        x, y = View(subject.link, moved).placed(tip.at)
        growing = term(dot((x, y), (x.derivative(), y.derivative())), 0)
        signs.add(1 if growing > 0 else -1 if growing < 0 else 0)
    return True if signs in ({1}, {-1}) else None


def _tip(subject: Subject, flank: Flank) -> Tip:
    return next(tip for tip in subject.link.tips if tip.path == flank.path)


@dataclass(frozen=True, eq=False)
class _Box:
    """A part of a piece: where roller centre and flank can be, on the cam.

    ``low``, ``high`` bound x; ``start``, ``turning`` [rad] are the tangent's heading at its low end
    and how far it can turn to either side of it.
    """

    piece: Piece
    low: arb
    high: arb
    centre: Place
    flank: Place
    heading: tuple[float, float]
    turning: float


class _Flank:
    """One flank, looked at box by box."""

    def __init__(self, subject: Subject, flank: Flank) -> None:
        self.link, self.tip = subject.link, _tip(subject, flank)
        self.distance = arb(flank.side * flank.distance)
        self.least = arb(flank.distance) * (1 - TOUCHING)
        self.course = subject.course
        self.halves: dict[_Box, tuple[_Box, _Box]] = {}
        self.pairs = 0

    def clear(self) -> bool | None:
        """Whether every far pair is far enough apart; None where that could not be told."""
        boxes = [box for piece in self.course.pieces for box in self._cut(piece)]
        return _all(self._apart(boxes[i], boxes[j], 0) for i, j in _far(boxes))

    def _near(self, a: _Box, b: _Box) -> bool:
        """Whether the roller at the middle of b reaches into the flank at the middle of a."""
        (x, y), (u, v) = self._middle(a).flank, self._middle(b).centre
        return bool((x - u) ** 2 + (y - v) ** 2 < self.least * self.least)

    def _middle(self, box: _Box) -> _Box:
        middle = ((box.low + box.high) / 2).mid()
        return self._box(box.piece, middle, middle)

    def _cut(self, piece: Piece) -> Iterator[_Box]:
        """Boxes along one piece, narrow enough and of little turning."""
        wide = float((piece.law.high - piece.law.low) * piece.angle)
        count = max(math.ceil(wide / WIDEST), 1)
        step = (piece.law.high - piece.law.low) / count
        open_parts = [
            (
                (piece.law.low + k * step).mid(),
                piece.law.high if k + 1 == count else (piece.law.low + (k + 1) * step).mid(),
            )
            for k in reversed(range(count))
        ]
        while open_parts:
            low, high = open_parts.pop()
            box = self._box(piece, low, high)
            if box.turning <= TURNING or float(high - low) < 1e-9:
                yield box
                continue
            middle = ((low + high) / 2).mid()
            open_parts += [(middle, high), (low, middle)]

    def _box(self, piece: Piece, low: arb, high: arb) -> _Box:
        x = hull(low, high)
        contact = self._contact(piece, x)
        tangent = rate(contact.curve())
        square = dot(tangent, tangent)
        if not term(square, 0).lower() > 0:  # too wide a box: the tangent might vanish
            lost = arb(0, arb.pos_inf())
            return _Box(piece, low, high, (lost, lost), (lost, lost), (0.0, 0.0), math.inf)
        # the heading on the cam, counter-clockwise: as seen from it the tangent turns so fast
        swept = term(cross(tangent, rate(tangent)) / square, 0)
        turning = float((abs(swept) * (high - low) * piece.angle).upper())
        ends = (self._heading(piece, low), self._heading(piece, high))
        return _Box(piece, low, high, *self._places(piece, x, contact), ends, turning)

    def _contact(self, piece: Piece, x: arb) -> TipContact:
        return TipContact(View(self.link, piece.displacement(x)), self.tip)

    def _heading(self, piece: Piece, x: arb) -> float:
        tx, ty = rate(self._contact(piece, x).curve())
        # in floating point: a ball on the cut of the angle could be anywhere on the circle
        return math.atan2(float(term(ty, 0)), float(term(tx, 0))) - float(piece.angle_at(x))

    def _places(self, piece: Piece, x: arb, contact: TipContact) -> tuple[Place, Place]:
        """Roller centre and flank on the cam over x, from value and rate about the middle."""
        middle = x.mid()
        near = self._contact(piece, middle)
        reach = (x - middle) * piece.angle
        found = []
        for here, over in zip(self._both(near), self._both(contact), strict=True):
            shift = [term(part, 0) * reach for part in rate(over)]
            seen = _seen((term(here[0], 0), term(here[1], 0)), piece.angle_at(middle))
            # the rate is told in the machine's frame, which the cam has left by up to the reach
            moved = _seen((shift[0], shift[1]), piece.angle_at(x))
            found.append((seen[0] + moved[0], seen[1] + moved[1]))
        return found[0], found[1]

    def _both(self, contact: TipContact) -> tuple[Pair, Pair]:
        """P and O = P − D n in the machine's frame."""
        x, y = contact.curve()
        nx, ny = contact.normal()
        length = dot((nx, ny), (nx, ny)).sqrt()
        return (x, y), (x - nx / length * self.distance, y - ny / length * self.distance)

    def _apart(self, a: _Box, b: _Box, depth: int) -> bool | None:
        """Whether the flank over a keeps from the roller over b."""
        dx, dy = a.flank[0] - b.centre[0], a.flank[1] - b.centre[1]
        square = dx * dx + dy * dy
        if square.lower() >= self.least * self.least:
            return True
        self.pairs += 1
        if self._near(a, b):
            return False
        if depth == DEEPEST or self.pairs > MOST_PAIRS:
            return None
        halves = self._halves(b)
        return _all(self._apart(x, y, depth + 1) for x in self._halves(a) for y in halves)

    def _halves(self, box: _Box) -> tuple[_Box, _Box]:
        if box not in self.halves:
            middle = ((box.low + box.high) / 2).mid()
            one = self._box(box.piece, box.low, middle)
            self.halves[box] = one, self._box(box.piece, middle, box.high)
        return self.halves[box]


def _all(verdicts: Iterable[bool | None]) -> bool | None:
    """Whether all of them hold: False as soon as one does not, None where one could not be told."""
    known: bool | None = True
    for verdict in verdicts:
        if verdict is False:
            return False
        known = known if verdict else None
    return known


def _seen(vector: Place, angle: arb) -> Place:
    """A vector of the machine's frame on a cam that has turned by an angle."""
    (x, y), cos, sin = vector, angle.cos(), angle.sin()
    return x * cos + y * sin, y * cos - x * sin


def _far(boxes: Sequence[_Box]) -> Iterator[tuple[int, int]]:
    """Pairs of boxes along both arcs between which the tangent may turn by π or more."""
    count = len(boxes)
    low, high, at = np.zeros(2 * count), np.zeros(2 * count), 0.0
    last = boxes[-1].heading[1]
    for k in range(2 * count):
        box = boxes[k % count]
        at += _turned(last, box.heading[0])  # at corners only
        end = at + _turned(*box.heading)
        low[k] = min(at, end) - box.turning - PADDING
        high[k] = max(at, end) + box.turning + PADDING
        at, last = end, box.heading[1]
    index = np.arange(count)
    near = np.zeros((count, count), dtype=bool)
    for i in range(count):
        spread = np.maximum.accumulate(high[i : i + count])
        spread = spread - np.minimum.accumulate(low[i : i + count])
        near[i, (index + i) % count] = spread < math.pi
    rows, columns = np.nonzero(~(near | near.T))
    yield from zip(rows.tolist(), columns.tolist(), strict=True)


def _turned(before: float, after: float) -> float:
    """From one heading to the next, by less than half a turn."""
    return math.remainder(after - before, 2.0 * math.pi)
