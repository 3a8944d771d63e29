"""Axes of diagrams, all of them logarithmic, and how their numbers are written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import floor, log10

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Axis:
    """One axis.

    Attributes:
        name: what it measures. number: how a value is written.
        least: what is smaller, zero above all, lies on the edge.
    """

    name: str
    number: Callable[[float], str]
    least: float | None = None


def seconds(value: float) -> str:
    """1 µs, 20 ms, 5 s."""
    for unit, name in ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")):
        if value >= 0.999 * unit:
            return f"{value / unit:.3g} {name}"
    return f"{value / 1e-9:.3g} ns"


def plain(value: float) -> str:
    """12, 0.5."""
    return f"{float(f'{value:.4g}'):,.12g}".replace(",", "\u202f")


def relative(value: float) -> str:
    """100-fold, 10 %, 0.5 %, 10⁻⁴, 2·10⁻⁶."""
    if value >= 9.99:
        return f"{plain(value)}-fold"
    if value >= 9.9e-4:
        return f"{100.0 * value:.4g} %"
    return power(value)


def power(value: float) -> str:
    """10⁻⁴, 2·10⁻⁶; but 0.1, 1, 10."""
    if 0.0999 <= value < 1e4:
        return plain(value)
    order = floor(log10(value) + 1e-9)
    first = value / 10.0**order
    ten = f"10{str(order).translate(SUPERSCRIPTS)}"
    return ten if abs(first - 1.0) < 1e-6 else f"{first:.2g}·{ten}"
