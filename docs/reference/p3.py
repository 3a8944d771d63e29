"""Print the tables of p3.md: both mechanisms, the pivot in the cam's way, points, the faults.

python docs/reference/p3.py
"""

import json
from math import acos, cos, degrees, pi, radians, sqrt
from pathlib import Path

import numpy as np

from docs.reference.tables import number, table
from synthesis import Analysis, DesignSpec, analyse
from synthesis.catalogue.motion import Motion
from synthesis.catalogue.profile import CamProfile, cam_profile

EXAMPLES = Path(__file__).resolve().parents[2] / "openapi/examples/analyses"
SENSES = ("opposite", "same")
ARM, DISTANCE, BASE, ROLLER, SWING = 85.0, 100.0, 80.0, 30.0, 45.0
PIVOT_DEG, RISE_DEG = 30.0, 80.0
TOO_LARGE = 160.0  # a base radius that the arm cannot reach


def example(sense: str) -> DesignSpec:
    text = (EXAMPLES / f"p3-{sense}.json").read_text(encoding="utf-8")
    return DesignSpec.model_validate(json.loads(text)["value"])


SPECS = {sense: example(sense) for sense in SENSES}


def profile(sense: str, theta: np.ndarray) -> CamProfile:
    spec = SPECS[sense]
    size = tuple(low for low, _ in spec.follower.size_domain(spec.base_radius_range()).bounds)
    return cam_profile(Motion.of(spec.placed_segments()), spec.follower, size, spec.rotation, theta)


def sizes(found: dict[str, Analysis]) -> None:
    reported = found["opposite"].dimensions
    units = {"mm": " mm", "deg": "°"}
    table(
        ("dimension", "value"),
        *(
            (name.rpartition("_")[0].replace("_", " "), number(value) + units[name.split("_")[-1]])
            for name, value in reported.items()
        ),
    )


def curves(found: dict[str, Analysis]) -> None:
    rows = [("curve", "over", "unit", "opposite", "at °", "same", "at °")]
    wanted = {
        ("velocity", "turn"), ("acceleration", "turn"), ("pressure_angle", "rise"),
        ("pressure_angle", "dwell"), ("pressure_angle", "return"), ("pitch_curvature", "turn"),
        ("convex_radius", "turn"), ("hollow_radius", "turn"),
    }  # fmt: skip
    for here, there in zip(*(found[sense].curves for sense in SENSES), strict=True):
        if (here.curve, here.over) not in wanted:
            continue
        digits = 6 if here.unit == "1/mm" else 4
        for end in ("largest", "smallest"):
            peaks = [getattr(curve, end) for curve in (here, there)]
            cells = [
                cell for peak in peaks if peak is not None
                for cell in (number(peak.value, digits), number(peak.angle_deg))
            ]  # fmt: skip
            if cells:
                rows.append((f"{end} {here.curve.replace('_', ' ')}", here.over, here.unit, *cells))
    table(*rows)


def over_the_pivot(sense: str) -> tuple[float, float]:
    """First and last cam angle at which the cam lies over the pivot's centre [deg]."""
    p = profile(sense, np.linspace(0.0, 2.0 * pi, 360_001))
    beyond = np.hypot(p.x, p.y) >= DISTANCE
    # a point at the polar angle φ of the cam's frame lies towards the pivot at γ − φ
    at = PIVOT_DEG - np.degrees(np.unwrap(np.arctan2(p.y, p.x)))[beyond]
    shift = 360.0 * np.floor((at.min() + 180.0) / 360.0)
    return float(at.min() - shift), float(at.max() - shift)


def pivot(found: dict[str, Analysis]) -> None:
    rows = [
        (
            "mechanism",
            "farthest point mm",
            "pivot at mm",
            "beyond mm",
            "cam over it, from °",
            "to °",
        )
    ]
    for sense in SENSES:
        reported = found[sense].dimensions
        first, last = over_the_pivot(sense)
        rows.append(
            (
                sense, number(reported["outer_radius_mm"]), number(reported["centre_distance_mm"]),
                number(-reported["pivot_clearance_mm"]), number(first, 2), number(last, 2),
            )
        )  # fmt: skip
    table(*rows)


def points() -> None:
    rows = [("θ °", "swing °", "pressure angle °", "pitch x mm", "y", "profile x mm", "y",
             "profile radius mm")]  # fmt: skip
    for sense in SENSES:
        angles = np.arange(0.0, 361.0, 40.0)
        p = profile(sense, np.radians(angles))
        for k, angle in enumerate(angles):
            values = (
                degrees(p.s[0, k] / ARM), degrees(p.pressure_angle[k]), p.pitch_x[k], p.pitch_y[k],
                p.x[k], p.y[k], p.radius[k],
            )  # fmt: skip
            rows.append((f"{angle:.0f}, {sense}", *(number(float(value)) for value in values)))
    table(*rows)


def start(prime: float) -> float:
    """ψ0 by the law of cosines [deg]."""
    return degrees(acos((DISTANCE**2 + ARM**2 - prime**2) / (2.0 * DISTANCE * ARM)))


def faults(found: dict[str, Analysis]) -> None:
    both = [
        max((c.largest.value, c.smallest.value), key=abs)
        for sense in SENSES
        for c in found[sense].curves
        if (c.curve, c.over) == ("pressure_angle", "turn")
    ]
    cosine = (DISTANCE**2 + ARM**2 - (TOO_LARGE + ROLLER) ** 2) / (2.0 * DISTANCE * ARM)
    table(
        ("what", "as programmed", "right"),
        (
            "prime radius; the arm's angle at rest",
            f"{BASE:.0f} mm; {number(start(BASE))}°",
            f"{BASE + ROLLER:.0f} mm; {number(start(BASE + ROLLER))}°",
        ),
        ("β of the rise in the 3-4-5 law", f"{number(RISE_DEG * pi / 13080)} rad (π/13080)",
         f"{number(radians(RISE_DEG))} rad (π/180)"),
        ("distance of the curve that is output from the profile", f"{ROLLER:.0f} mm", "0 mm"),
        ("largest pressure angle in the other direction", "the same, mirrored",
         f"{number(both[0])}° and {number(both[1])}°"),
        (f"cosine of the arm's angle at rest, base radius {TOO_LARGE:.0f} mm",
         f"{number(cosine)}: acos fails",
         f"refused: {ARM:.0f} mm reach from {DISTANCE - ARM:.0f} to {DISTANCE + ARM:.0f} mm"),
    )  # fmt: skip


def main() -> None:
    found = {sense: analyse(SPECS[sense]) for sense in SENSES}
    highest = sqrt(DISTANCE**2 + ARM**2 - 2 * DISTANCE * ARM * cos(radians(start(110.0) + SWING)))
    assert abs(highest - ROLLER - found["same"].dimensions["outer_radius_mm"]) < 1e-9
    sizes(found)
    curves(found)
    pivot(found)
    points()
    faults(found)


if __name__ == "__main__":
    main()
