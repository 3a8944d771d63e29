"""A machine in motion beside its diagrams: what every animation shows, whatever the machine is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.figures.machine import Moving, Tag
from synthesis.numerics.piecewise import Array

Body = Callable[[Tag], list[str]]
TURN_S = 8.0  # what one turn takes on the screen


@dataclass(frozen=True, eq=False)
class Scene:
    """A scene over one turn of a shaft.

    Attributes:
        name, about: of the machine, in a line each. key: its id.
        heading: both as elements of a sheet. shaft: what the turn is of, as in ``Cam angle``.
        titles: of the two panels. described: what is seen, in a sentence.
        machine, diagrams: elements of the panels, their parts named by the tag.
        moving: everything that moves. readings: numbers that follow. decimals: of coordinates.
        rules: style of the machine's lines. footer: what is told below.
    """

    name: str
    about: str
    key: str
    heading: Sequence[str]
    shaft: str
    titles: tuple[str, str]
    described: str
    machine: Body
    diagrams: Body
    moving: Sequence[Moving]
    readings: Sequence[dict[str, Any]]
    decimals: int
    rules: str
    footer: str


def lasting(turn_s: float) -> str:
    """How long a turn takes, and how long it is shown."""
    return f"One turn is shown in {TURN_S:g} s; it takes {svg.figure(turn_s)} s."


def reading(name: str, title: str, unit: str, values: Array, size: float) -> dict[str, Any]:
    """A number that follows the motion, rounded to four digits of its size."""
    digits = int(np.clip(3 - np.floor(np.log10(size)), 0, 9)) if size > 0.0 else 1
    rounded = [round(v, digits) if np.isfinite(v) else None for v in values.tolist()]
    return {"name": name, "title": title, "unit": unit, "digits": digits, "column": rounded}


def grouped(name: str, tag: Tag, moving: Sequence[Moving], body: Sequence[str]) -> list[str]:
    """A part that moves, where it stands first."""
    first = next((part.first for part in moving if part.name == name), "translate(0 0)")
    return [f'<g {tag(name)} transform="{first}">', *body, "</g>"]
