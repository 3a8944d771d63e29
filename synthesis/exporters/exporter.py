"""What every file format promises."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Generic, TypeVar

from synthesis.design import Design
from synthesis.exporters.options import Options

Wanted = TypeVar("Wanted", bound=Options)


@dataclass(frozen=True)
class Exporter(Generic[Wanted]):
    """A file format. The same design and options give the same bytes.

    Attributes:
        name: as in ``profile.{name}``. title: for people.
        media_type: for HTTP. extension: of the file, with its dot.
        write: design and options to the file's bytes; InputError where there is no cam to write.
        options: what may be chosen; all of it has a default.
        purpose: what it is for, in a sentence; "" where the title says it.
        placeable: whether a profile's points follow ``turn_deg`` and ``z_mm``.
        usual: whether it is written where nobody says which formats are wanted.
    """

    name: str
    title: str
    media_type: str
    extension: str
    write: Callable[[Design, Wanted], bytes]
    options: type[Wanted]
    purpose: str = ""
    placeable: bool = True
    usual: bool = True

    def adapted(self, given: Options) -> Wanted:
        """This format's options with what they share with another's."""
        own = {each.name for each in fields(self.options)}
        shared = [each.name for each in fields(given) if each.name in own]
        return self.options(**{name: getattr(given, name) for name in shared})
