"""Regions between two walls, at the ribs' tops or at the grooves' floor, sector by sector."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby

from synthesis.spatial.smooth.sheets import HIGH, LOW, Piece, Sheets, Stop

TOP, ROOT = 0, -1  # depths of the blank


@dataclass(frozen=True, eq=False)
class Span:
    """A part of a region's turn in which both of its bounds do one thing.

    Attributes:
        low, high: the pieces that bound it; None: nothing does, up to the blank's end.
        first, last: where it begins and ends.
    """

    low: Piece | None
    high: Piece | None
    first: Stop
    last: Stop

    @property
    def states(self) -> tuple[int, int]:
        low = LOW if self.low is None else self.low.state
        return low, HIGH if self.high is None else self.high.state

    @property
    def open(self) -> bool:
        """Whether there is any of the region."""
        low, high = self.states
        return low != HIGH and high != LOW


def pairs(sheets: Sheets, level: int) -> Iterator[tuple[int, int]]:
    """Walls that bound regions: of ribs at the tops, of grooves at the floor."""
    count = len(sheets.states)
    if level == TOP:
        return ((k - 1, k) for k in range(0, count + 1, 2))
    return ((k, k + 1) for k in range(0, count, 2))


def spans(sheets: Sheets, j: int, low: int, high: int, level: int) -> Iterator[Span]:
    """What lies between two walls in a sector, cut where either leaves the blank or enters it."""
    lows, highs = _of(sheets, j, low), _of(sheets, j, high)
    first, end = sheets.line(j), sheets.line(j + 1)
    a = b = 0
    while True:
        here = [piece.last for piece in (lows[a], highs[b]) if piece is not None]
        stops = [stop for stop in here if stop.key[0] == "out"]
        last = min(stops, key=lambda stop: float(stop.turn[level]), default=end)
        yield Span(lows[a], highs[b], first, last)
        if last is end:
            return
        a, b = a + _ends(lows[a], last), b + _ends(highs[b], last)
        first = last


def _of(sheets: Sheets, j: int, wall: int) -> list[Piece | None]:
    """A wall's pieces; below the first wall and above the last there is none."""
    return [*sheets.pieces[j][wall]] if 0 <= wall < len(sheets.states) else [None]


def _ends(piece: Piece | None, stop: Stop) -> bool:
    return piece is not None and piece.last is stop


def runs(spans: Iterable[Span]) -> Iterator[list[Span]]:
    """Neighbouring spans in which there is any of the region."""
    return (list(run) for there, run in groupby(spans, lambda span: span.open) if there)


def bounds(run: Iterable[Span], k: int) -> Iterator[tuple[Piece | None, int, Stop, Stop]]:
    """What bounds a run below (0) or above (1), piece by piece, from where to where."""
    for _, spans in groupby(run, lambda span: id((span.low, span.high)[k])):
        all_ = list(spans)
        piece = (all_[0].low, all_[0].high)[k]
        yield piece, all_[0].states[k], all_[0].first, all_[-1].last
