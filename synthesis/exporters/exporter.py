"""What every file format promises."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from synthesis.design import Design

Options = TypeVar("Options")


@dataclass(frozen=True)
class Exporter(Generic[Options]):
    """A file format. The same design and options give the same bytes.

    Attributes:
        name: as in ``profile.{name}``. title: for people.
        media_type: for HTTP. extension: of the file, with its dot.
        write: design and options to the file's bytes; InputError where there is no cam to write.
        placeable: whether a profile's points follow ``turn_deg`` and ``z_mm``.
        without_cam: whether it has something to write where no cam was found.
    """

    name: str
    title: str
    media_type: str
    extension: str
    write: Callable[[Design, Options], bytes]
    placeable: bool = True
    without_cam: bool = False
