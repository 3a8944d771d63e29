"""Cams designed by optimisation: the numerical core, an ordinary library.

    from synthesis import DesignSpec, synthesise
    design = synthesise(DesignSpec.model_validate(body))

``analyse(spec)`` for a cam that is given in full, ``synthesise_set(CamSetSpec…)`` for several cams
on one shaft, ``confirm(design)`` for a second opinion to the last digit, and ``proof(design)`` for
a file that ``checker/check.py`` checks without this program.

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
    from synthesis.certify.second import Confirmation, confirm
    from synthesis.design.analysis import Analysis
    from synthesis.design.cam_set import CamSet
    from synthesis.design.design import Design
    from synthesis.machines.spatial.design import SpatialDesign
    from synthesis.machines.spatial.pipeline import synthesise_spatial
    from synthesis.machines.spatial.spec import SpatialCamSpec
    from synthesis.pipeline.proof_file import proof
    from synthesis.pipeline.synthesise import synthesise
    from synthesis.spec.cam_set import CamSetSpec
    from synthesis.spec.design_spec import DesignSpec
    from synthesis.studies.analyse import analyse
    from synthesis.studies.cam_set import synthesise_set
    from synthesis.studies.sensitivity import sensitivities
    from synthesis.studies.sweeps.spec import SweepSpec

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
    "proof",
    "sensitivities",
    "synthesise",
    "synthesise_set",
    "synthesise_spatial",
]

_HOMES = {
    "Analysis": "synthesis.design.analysis",
    "CamSet": "synthesis.design.cam_set",
    "CamSetSpec": "synthesis.spec.cam_set",
    "Confirmation": "synthesis.certify.second",
    "Design": "synthesis.design.design",
    "DesignSpec": "synthesis.spec.design_spec",
    "SpatialCamSpec": "synthesis.machines.spatial.spec",
    "SpatialDesign": "synthesis.machines.spatial.design",
    "SweepSpec": "synthesis.studies.sweeps",
    "analyse": "synthesis.studies.analyse",
    "sensitivities": "synthesis.studies.sensitivity",
    "confirm": "synthesis.certify.second",
    "notebook_display": "synthesis.exporters.report.notebook",
    "proof": "synthesis.pipeline.proof_file",
    "synthesise": "synthesis.pipeline.synthesise",
    "synthesise_set": "synthesis.studies.cam_set",
    "synthesise_spatial": "synthesis.machines.spatial.pipeline",
}


def __getattr__(name: str) -> Any:
    """Import on first use, so that a service that only validates loads no solver."""
    if name not in _HOMES:
        raise AttributeError(f"module 'synthesis' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)
