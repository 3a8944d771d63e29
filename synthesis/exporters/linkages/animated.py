"""Animations of a linkage, whatever kind it is: from its scene to an SVG and to a page."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from synthesis.exporters.animations.animation_page import FRAMES as PAGE_FRAMES
from synthesis.exporters.animations.animation_page import paged
from synthesis.exporters.animations.animation_svg import FRAMES, drawn
from synthesis.exporters.animations.scene import Scene
from synthesis.exporters.drawing.picture_options import PictureOptions
from synthesis.exporters.exporter import untold
from synthesis.exporters.linkages.file import LinkageFile

SceneOf = Callable[[Any, int], Scene]  # an answer, and how many frames of its turn


def as_svg(scene: SceneOf, purpose: str) -> LinkageFile:
    """The scene as one SVG."""

    def write(found: Any, options: PictureOptions) -> bytes:
        return drawn(scene(found, FRAMES), options.theme)

    title, made = "Animation", untold(write)
    return LinkageFile(
        "animation.svg", title, "image/svg+xml", ".svg", made, PictureOptions, purpose
    )


def as_page(scene: SceneOf) -> LinkageFile:
    """The scene as a page with controls and numbers."""

    def write(found: Any, options: PictureOptions) -> bytes:
        return paged(scene(found, PAGE_FRAMES), options.theme)

    return LinkageFile(
        "animation.html", "Animation to play, stop and read", "text/html; charset=utf-8", ".html",
        untold(write), PictureOptions,
        "One file that needs no network; by mouse, touch and keys.",
    )  # fmt: skip
