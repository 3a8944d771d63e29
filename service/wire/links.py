"""Addresses of answers and of their files."""

from __future__ import annotations

from collections.abc import Collection

from synthesis.exporters import (
    DRAWINGS,
    MOTION_FORMATS,
    PICTURES,
    PROFILE_FORMATS,
    SOLID_FORMATS,
)
from synthesis.machines.spatial.files import formats_of


def design_links(design_id: str, *, has_cam: bool) -> dict[str, str]:
    """Of a design; where no cam fits, it has few files."""
    self = f"/v1/designs/{design_id}"
    links = {"self": self}
    if has_cam:
        links |= {f"profile.{name}": f"{self}/profile.{name}" for name in PROFILE_FORMATS}
        links |= {f"motion.{name}": f"{self}/motion.{name}" for name in MOTION_FORMATS}
        links |= {f"solid.{name}": f"{self}/solid.{name}" for name in SOLID_FORMATS}
    shown = (name for name, each in PICTURES.items() if has_cam or each.without_cam)
    return links | {name: f"{self}/{name}" for name in shown}


def analysis_links(analysis_id: str) -> dict[str, str]:
    """Of an analysis."""
    self = f"/v1/analyses/{analysis_id}"
    return {"self": self, **{name: f"{self}/{name}" for name in DRAWINGS}}


def linkage_links(kind: str, name: str, files: Collection[str]) -> dict[str, str]:
    """Of a linkage of a kind."""
    self = f"/v1/linkages/{kind}/{name}"
    return {"self": self, **{file: f"{self}/{file}" for file in files}}


def spatial_links(cam_id: str, machine: str, *, has_cam: bool) -> dict[str, str]:
    """Of a spatial cam; where none fits, it has no files."""
    self = f"/v1/spatial-cams/{cam_id}"
    files = formats_of(machine) if has_cam else ()
    return {"self": self, **{name: f"{self}/{name}" for name in files}}


def train_links(train_id: str) -> dict[str, str]:
    """Of a train response."""
    self = f"/v1/train-responses/{train_id}"
    files = ("response.csv", "response.svg", "spectrum.svg", "polydyne.csv")
    return {"self": self, **{name: f"{self}/{name}" for name in files}}


def set_links(set_id: str, *, has_cams: bool) -> dict[str, str]:
    """Of a cam set; where no cam fits, it has no files."""
    self = f"/v1/cam-sets/{set_id}"
    files = ("timing.svg", "bundle.zip") if has_cams else ()
    return {"self": self, **{name: f"{self}/{name}" for name in files}}
