"""What a cam leaves an oscillator ringing with: Duhamel's integral of s'' itself, by quadrature."""

from __future__ import annotations

from collections.abc import Iterable
from math import pi, sqrt
from typing import Any

import numpy as np

from tests.hard.own_cam import PlacedSegment

NODES, WEIGHTS = np.polynomial.legendre.leggauss(20)


def amplitudes(moves: list[PlacedSegment], omega: float, limit: dict[str, Any]) -> list[float]:
    """One for each run between two dwells, in the unit of the lifts."""
    nu = 2.0 * pi * limit["natural_frequency_hz"] / omega
    zeta = limit.get("damping_ratio", 0.0)
    damped = nu * sqrt(1.0 - zeta**2)
    return [abs(_sum(run, zeta * nu, damped)) / damped for run in _runs(moves)]


def _runs(moves: list[PlacedSegment]) -> Iterable[list[PlacedSegment]]:
    """The moves between dwells, from the first dwell round the turn."""
    first = next(k for k, move in enumerate(moves) if move.kind == "dwell")
    run: list[PlacedSegment] = []
    for move in [*moves[first + 1 :], *moves[: first + 1]]:
        if move.kind != "dwell":
            run.append(move)
        elif run:
            yield run
            run = []


def _sum(run: list[PlacedSegment], decay: float, damped: float) -> complex:
    """∫ s'' e^(−(decay − i damped)(end − θ)) dθ, jumps of s' and all."""
    total, after, behind = 0j, sum(move.beta for move in run), 0.0
    for move in run:
        for piece, (low, high, _) in enumerate(move.pieces):
            ahead = after - move.beta * np.array([low, high])
            speed = move.at(piece, np.array([low, high]), 1)
            total += (speed[0] - behind) * np.exp(-(decay - 1j * damped) * ahead[0])
            behind = float(speed[1])
            count = int(np.ceil(damped * move.beta * (high - low) / 2.0)) + 3
            ends = np.linspace(low, high, count + 1)
            half = 0.5 * np.diff(ends)[:, None]
            x = (ends[:-1, None] + half * (NODES + 1.0)).ravel()
            wave = np.exp(-(decay - 1j * damped) * (after - move.beta * x))
            inside = (move.at(piece, x, 2) * wave).reshape(len(half), -1)
            total += complex(np.sum(half * (inside @ WEIGHTS)[:, None])) * move.beta
        after -= move.beta
    return total - behind  # at rest in the dwell
