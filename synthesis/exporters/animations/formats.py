"""Animations as files: SVG, page and data, of cams and of any machine with a scene."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from synthesis.design.design import Design
from synthesis.exporters.animations import animation_page, animation_svg
from synthesis.exporters.animations.cam_scene import cam_scene
from synthesis.exporters.animations.scene import Scene
from synthesis.exporters.exporter import Exporter, FileFormat, compact_json
from synthesis.exporters.figures.machine import Stage
from synthesis.exporters.options import Options, PictureOptions
from synthesis.exporters.samples.cam import Cam

FRAMES = 360  # positions of the data over a turn
FRAME = (
    "shapes: SVG elements in mm of the machine's frame, y upwards; its parts carry data-part. "
    "outline: the cam's own at cam angle 0. mirror: -1 where all of it, moves too, is to be "
    "mirrored at the y axis, as the cam turns clockwise. parts: over a turn, evenly spaced, "
    "the angle [deg] of a turn, counter-clockwise, or x and y [mm] of a shift; two values are a "
    "straight line. extent: left, bottom, right and top of all that is swept [mm]."
)
Format = TypeVar("Format", bound=FileFormat[Any, Any])


def pictures(
    kind: type[Format], scene: Callable[[Any, int], Scene], title: str, purpose: str
) -> tuple[Format, Format]:
    """The animated SVG and the page of a scene, made from an answer and a number of frames."""

    def picture(answer: Any, options: PictureOptions) -> bytes:
        return animation_svg.draw(scene(answer, animation_svg.FRAMES), options.theme)

    def page(answer: Any, options: PictureOptions) -> bytes:
        return animation_page.page(scene(answer, animation_page.FRAMES), options.theme)

    return (
        kind("animation.svg", title, "image/svg+xml", ".svg", picture, PictureOptions, purpose),
        kind(
            "animation.html", "Animation to play, stop and read", "text/html; charset=utf-8",
            ".html", page, PictureOptions,
            "One file that needs no network; by mouse, touch and keys.",
        ),
    )  # fmt: skip


def data(kind: type[Format], write: Callable[[Any, Options], bytes], title: str) -> Format:
    """The animation as JSON, which ``write`` makes; written only where it is named."""
    return kind(
        "animation.json", title, "application/json", ".json", write, Options,
        "For pages that show the machine their own way.", by_default=False,
    )  # fmt: skip


def _cam_json(design: Design, options: Options) -> bytes:
    stage = Stage.of(Cam.of(design), design.dimensions["base_radius_mm"], FRAMES, in_mm=True)
    left, bottom, right, top = stage.extent
    sides = (left, right) if stage.mirror > 0.0 else (-right, -left)
    body = {
        "kind": "animation",
        "design": {"id": design.id, "name": design.name, "status": design.status},
        "frame": FRAME,
        "mirror": int(stage.mirror),
        "extent": [sides[0], bottom, sides[1], top],
        "shapes": "\n".join(stage.shapes(animation_page.tag)),
        "outline": stage.outline(),
        "parts": [p.data(stage.decimals) for p in stage.moving() if p.moves],
    }
    return compact_json(body) + b"\n"


CAM = (
    *pictures(
        Exporter, cam_scene, "Animation of cam and follower",
        "For a document or a web page; no script.",
    ),
    data(Exporter, _cam_json, "Shapes and positions of cam and follower"),
)  # fmt: skip
