"""The shaft in the middle of a cam: its hub, by a rule of the field, and keyways by DIN 6885-1."""

from __future__ import annotations

from math import hypot

HUB_PER_SHAFT, HUB_MORE = 1.75, 6.35
"""Diameter of a hub of cast iron: 1 3/4 shaft diameters + 1/4 in [mm] (Rothbart, ed., Cam Design
Handbook, 2004, section 6.4.4, eq. 6.21; of steel slightly less)."""
HUB_RULE = f"{HUB_PER_SHAFT:g} shaft diameters + {HUB_MORE:g} mm"  # for people
LEAST_BORE = 6.0  # [mm]: for smaller ones there are no keys
# Bores up to … [mm], width of the key, depth of the keyway in the hub beyond the bore.
KEYWAYS = (
    (8.0, 2.0, 1.0), (10.0, 3.0, 1.4), (12.0, 4.0, 1.8), (17.0, 5.0, 2.3), (22.0, 6.0, 2.8),
    (30.0, 8.0, 3.3), (38.0, 10.0, 3.3), (44.0, 12.0, 3.3), (50.0, 14.0, 3.8), (58.0, 16.0, 4.3),
    (65.0, 18.0, 4.4), (75.0, 20.0, 4.9), (85.0, 22.0, 5.4), (95.0, 25.0, 5.4), (110.0, 28.0, 6.4),
    (130.0, 32.0, 7.4), (150.0, 36.0, 8.4), (170.0, 40.0, 9.4), (200.0, 45.0, 10.4),
    (230.0, 50.0, 11.4),
)  # fmt: skip
KEYED_BORES = "DIN 6885-1 has keys for bores above 6 and up to 230 mm."


def hub_diameter(shaft_diameter: float) -> float:
    """Diameter of the hub of a shaft, both in mm, by the rule for cast iron."""
    return HUB_PER_SHAFT * shaft_diameter + HUB_MORE


def shaft_of_hub(diameter: float) -> float:
    """The largest shaft for which a hub leaves room: the inverse of ``hub_diameter`` [mm]."""
    return (diameter - HUB_MORE) / HUB_PER_SHAFT


def standard_keyway(bore: float) -> tuple[float, float] | None:
    """Width of the keyway of a bore, and its depth beyond the bore [mm]; None: there is none."""
    sizes = (row[1:] for row in KEYWAYS if LEAST_BORE < bore <= row[0])
    return next(sizes, None)


def keyway_reach(bore: float) -> float:
    """How far the corners of the keyway of a bore are from the axis [mm]; 0: there is none."""
    sizes = standard_keyway(bore)
    return 0.0 if sizes is None else hypot(0.5 * sizes[0], 0.5 * bore + sizes[1])
