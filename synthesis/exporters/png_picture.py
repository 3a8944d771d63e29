"""The drawings as pixels, for where vectors are not taken."""

from __future__ import annotations

from typing import Any

from synthesis.design.design import Design
from synthesis.exporters.diagrams.contact import CONTACT
from synthesis.exporters.diagrams.motion import MOTION
from synthesis.exporters.drawing.raster import rasterise
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.figures.profile import PROFILE
from synthesis.exporters.options import (
    CamDrawingOptions,
    DiagramOptions,
    PictureOptions,
    PixelOptions,
)


def _painted(name: str, drawing: Exporter[Any], options: type[Any]) -> Exporter[PixelOptions]:
    def write(design: Design, given: PixelOptions) -> bytes:
        return rasterise(drawing.write(design, options(theme=given.theme)), given.width_px)

    return Exporter(
        f"{name}.png", f"{drawing.title}, pixels", "image/png", ".png", write, PixelOptions,
        "Needs the optional part plots; without it the answer is 501.", by_default=False,
        in_worker=True,
    )  # fmt: skip


PIXELS = (
    _painted("profile", PROFILE, CamDrawingOptions),
    _painted("motion", MOTION, DiagramOptions),
    _painted("contact", CONTACT, PictureOptions),
)
