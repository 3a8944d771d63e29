"""Addresses of what belongs to a design."""

from __future__ import annotations

from synthesis.exporters import MOTION_FORMATS, PROFILE_FORMATS


def links_of(design_id: str, *, has_cam: bool) -> dict[str, str]:
    """Where the design and its files are; where nothing fits there is no cam to draw."""
    self = f"/v1/designs/{design_id}"
    links = {"self": self}
    if has_cam:
        links |= {f"profile.{name}": f"{self}/profile.{name}" for name in PROFILE_FORMATS}
        links |= {f"motion.{name}": f"{self}/motion.{name}" for name in MOTION_FORMATS}
    return links
