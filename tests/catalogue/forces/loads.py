"""Loads of every family, at sizes where nothing is special."""

from __future__ import annotations

from typing import Any

from synthesis.spec.design_spec import DesignSpec
from tests.catalogue.followers.samples import SAMPLES, spec

STEEL = {"width_mm": 13.7, "cam": {"elastic_modulus_mpa": 203e3, "poisson_ratio": 0.29}}
SLIDE: dict[str, Any] = {
    "kind": "slide", "moving_mass_kg": 1.83, "damping_n_s_per_m": 41.0,
    "spring": {"rate_n_per_mm": 7.9, "preload_n": 310.0}, "rise_from_vertical_deg": 37.0,
    "process": [
        {"angle_deg": 13.0, "force_n": 80.0}, {"angle_deg": 120.5, "force_n": 610.0},
        {"angle_deg": 120.5, "force_n": 90.0},
    ],
    "contact": STEEL, "bearing": {"dynamic_rating_n": 9_600.0},
}  # fmt: skip
ARM: dict[str, Any] = {
    "kind": "arm", "moment_of_inertia_kg_m2": 0.0173, "damping_n_m_s_per_rad": 0.37,
    "spring": {"rate_n_m_per_rad": 61.0, "preload_n_m": 29.0},
    "process": [
        {"angle_deg": 13.0, "moment_n_m": 4.0}, {"angle_deg": 120.5, "moment_n_m": 37.0},
        {"angle_deg": 120.5, "moment_n_m": 3.0},
    ],
    "contact": STEEL, "bearing": {"dynamic_rating_n": 9_600.0},
}  # fmt: skip


def load_of(kind: str, sample: int = 0) -> dict[str, Any]:
    """The load that suits a family; in a ring the process pulls outwards, on to the cam."""
    load = ARM if "oscillating" in kind else SLIDE
    closure = SAMPLES[kind][sample][0].get("closure", {})
    if closure.get("contact") != "inside":
        return load
    turned = [
        {name: value if name == "angle_deg" else -value for name, value in point.items()}
        for point in load["process"]
    ]
    return load | {"process": turned}


def loaded(kind: str, sample: int = 0, **changes: Any) -> DesignSpec:
    """A given cam of a family with its load."""
    return spec(kind, sample, load=load_of(kind, sample), **changes)


def edged(kind: str, sample: int) -> bool:
    """Whether it is a knife edge."""
    return SAMPLES[kind][sample][0].get("roller_radius_mm") == 0.0
