"""Cams designed by optimisation: the numerical core, an ordinary library.

    from synthesis import DesignSpec, synthesise
    design = synthesise(DesignSpec.model_validate(body))

``analyse(spec)`` for a cam that is given in full, ``synthesise_set(CamSetSpec…)`` for several cams
on one shaft, and ``confirm(design)`` for a second opinion to the last digit.

Notation, used throughout (lengths in mm, angles in rad, derivatives per radian of cam angle):

    θ, β     cam angle; angle of a segment        x = (θ − start)/β, from 0 to 1
    s        displacement from the lowest position; s', s'', s''' its derivatives
    h        lift of a segment                    g(x) normalised law, s = s_start + h g
    ω        cam speed [rad/s]; v = s'ω, a = s''ω², j = s'''ω³
    Rb, Rr   base radius (of the profile), roller radius; Rp = Rb + Rr prime radius
    e        offset; s0 = √(Rp² − e²); X = s0 + s; u = s' − e
    α        pressure angle; κ, ρ signed curvature and its radius, convex positive
    z        the follower's size variables, (e, s0) of a translating roller, (Rb) of a face
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from synthesis.analysis import analyse
    from synthesis.camset import CamSet
    from synthesis.camset_spec import CamSetSpec
    from synthesis.confirmation import Confirmation, confirm
    from synthesis.design import Design
    from synthesis.findings import Analysis
    from synthesis.pipeline import synthesise
    from synthesis.sensitivity import sensitivities
    from synthesis.set_synthesis import synthesise_set
    from synthesis.spatial.design import SpatialDesign
    from synthesis.spatial.pipeline import synthesise_spatial
    from synthesis.spatial.spec import SpatialCamSpec
    from synthesis.spec import DesignSpec
    from synthesis.sweeps.spec import SweepSpec

__all__ = [
    "Analysis",
    "CamSet",
    "CamSetSpec",
    "Confirmation",
    "Design",
    "DesignSpec",
    "SpatialCamSpec",
    "SpatialDesign",
    "SweepSpec",
    "analyse",
    "confirm",
    "sensitivities",
    "synthesise",
    "synthesise_set",
    "synthesise_spatial",
]

_HOMES = {
    "Analysis": "synthesis.findings",
    "CamSet": "synthesis.camset",
    "CamSetSpec": "synthesis.camset_spec",
    "Confirmation": "synthesis.confirmation",
    "Design": "synthesis.design",
    "DesignSpec": "synthesis.spec",
    "SpatialCamSpec": "synthesis.spatial.spec",
    "SpatialDesign": "synthesis.spatial.design",
    "SweepSpec": "synthesis.sweeps",
    "analyse": "synthesis.analysis",
    "sensitivities": "synthesis.sensitivity",
    "confirm": "synthesis.confirmation",
    "synthesise": "synthesis.pipeline",
    "synthesise_set": "synthesis.set_synthesis",
    "synthesise_spatial": "synthesis.spatial.pipeline",
}


def __getattr__(name: str) -> Any:
    """Import on first use, so that a service that only validates loads no solver."""
    if name not in _HOMES:
        raise AttributeError(f"module 'synthesis' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)
