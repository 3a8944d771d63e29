"""A spatial cam as tables for a terminal."""

from __future__ import annotations

from collections.abc import Iterator

from rich.table import Table

from service.commands.tables.analysis_table import headed, number
from synthesis.machines.spatial.design import SpatialDesign

WIDTH = 100  # what the widest table needs


def headline(found: SpatialDesign) -> str:
    """The answer in one line."""
    broken = ", ".join(each.quantity for each in found.extremes if not each.holds)
    sizes = ", ".join(f"{name} {value:.4f}" for name, value in found.dimensions.items())
    verdict = f"{found.status}, violated: {broken}" if broken else found.status
    return f"{verdict}; {sizes}"


def tables(found: SpatialDesign) -> Iterator[Table]:
    """Walls, and what was measured of them."""
    yield _walls(found)
    yield _extremes(found)


def _walls(found: SpatialDesign) -> Table:
    rows = headed("Walls", "wall", "from °", "to °")
    for wall in found.walls:
        for arc in wall.arcs:
            rows.add_row(wall.name, f"{arc.start_deg:.3f}", f"{arc.end_deg:.3f}")
    return rows


def _extremes(found: SpatialDesign) -> Table:
    rows = headed(
        "Measured", "quantity", "value", "unit", "at °", "wall", "rho mm", "allowed", "margin", ""
    )
    for e in found.extremes:
        verdict = "" if e.bound is None else "holds" if e.holds else "BROKEN"
        rows.add_row(
            e.quantity, number(e.value), e.unit, _angle(e.angle_deg),
            f"{e.roller}{e.side}" if e.side else "–", number(e.rho_mm), number(e.bound),
            number(e.margin), verdict,
        )  # fmt: skip
    return rows


def _angle(value: float | None) -> str:
    return "–" if value is None else f"{value:.3f}"
