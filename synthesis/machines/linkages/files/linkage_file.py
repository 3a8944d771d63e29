"""LinkageFile: a file of a linkage; animations of any kind of linkage from its scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from synthesis.exporters.animations.animation_page import FRAMES as PAGE_FRAMES
from synthesis.exporters.animations.animation_page import paged
from synthesis.exporters.animations.animation_svg import FRAMES, drawn
from synthesis.exporters.animations.scene import Scene
from synthesis.exporters.drawing.picture_options import PictureOptions
from synthesis.exporters.exporter import FileFormat, untold


@dataclass(frozen=True)
class LinkageFile(FileFormat[Any, Any]):
    """A file made from the answer about a linkage; its name is the file name: ``motion.csv``.

    Attributes:
        suits: whether it can be made from an answer that has a linkage. Others as ``FileFormat``.
    """

    suits: Callable[[Any], bool] = lambda _: True


SceneOf = Callable[[Any, int], Scene]  # an answer, and how many frames of its turn


def animation_svg(scene: SceneOf, purpose: str) -> LinkageFile:
    """The file of a scene as an animated SVG."""

    def write(found: Any, options: PictureOptions) -> bytes:
        return drawn(scene(found, FRAMES), options.theme)

    title, made = "Animation", untold(write)
    return LinkageFile(
        "animation.svg", title, "image/svg+xml", ".svg", made, PictureOptions, purpose
    )


def animation_page(scene: SceneOf) -> LinkageFile:
    """The file of a scene as a page with controls and readings."""

    def write(found: Any, options: PictureOptions) -> bytes:
        return paged(scene(found, PAGE_FRAMES), options.theme)

    return LinkageFile(
        "animation.html", "Animation to play, stop and read", "text/html; charset=utf-8", ".html",
        untold(write), PictureOptions,
        "One file that needs no network; by mouse, touch and keys.",
    )  # fmt: skip
