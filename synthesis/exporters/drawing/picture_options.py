"""What a caller may choose about drawings and pages."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from synthesis.exporters.drawing.theme import Theme
from synthesis.exporters.options import MotionOptions, Options, ProfileOptions

Colours = Annotated[
    Theme,
    Field(
        description="`auto` is light, and dark on a screen that asks for it; `print` is black on "
        "white."
    ),
]


@dataclass(frozen=True)
class PictureOptions(Options):
    """How a picture or a page looks."""

    theme: Colours = "auto"


PixelColours = Annotated[
    Literal["light", "dark", "print"],
    Field(description="`print` is black on white; there is no `auto`: pixels know no screen."),
]
PixelWidth = Annotated[int, Field(ge=200, le=6000, description="Width of the picture.")]


@dataclass(frozen=True)
class PixelOptions(Options):
    """How a picture of pixels looks; its height follows from its width."""

    theme: PixelColours = "light"
    width_px: PixelWidth = 1600


@dataclass(frozen=True)
class CamDrawingOptions(ProfileOptions):
    """How finely the drawing of a cam is drawn, and how it looks."""

    theme: Colours = "auto"


@dataclass(frozen=True)
class DiagramOptions(MotionOptions):
    """How finely diagrams of the motion are drawn, and how they look."""

    theme: Colours = "auto"
