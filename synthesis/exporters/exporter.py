"""What every file format promises."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Generic, TypeVar

from synthesis.design.design import Design
from synthesis.exporters.options import Options

Subject = TypeVar("Subject")
Wanted = TypeVar("Wanted", bound=Options)


@dataclass(frozen=True)
class Made:
    """A file.

    Attributes:
        data: its bytes.
        told: what is known of it and does not stand in it, or not for all to read: how far it is
            from the true curve. In words that serve as HTTP headers: ``Curve-Error-Mm``.
    """

    data: bytes
    told: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class FileFormat(Generic[Subject, Wanted]):
    """A file format of some subject. The same subject and options give the same bytes.

    Attributes:
        name: as in ``profile.{name}``. title: for people.
        media_type: for HTTP. extension: of the file, with its dot.
        make: subject and options to the file; InputError where there is no cam to write.
        options: what may be chosen; all of it has a default.
        purpose: what it is for, in a sentence; "" where the title says it.
        usual: whether it is written where nobody says which formats are wanted.
        apart: whether it loads so much that a service has it made by a worker.
        measured: what is told of a file besides and takes time to find; None: nothing.
    """

    name: str
    title: str
    media_type: str
    extension: str
    make: Callable[[Subject, Wanted], Made]
    options: type[Wanted]
    purpose: str = ""
    usual: bool = True
    apart: bool = False
    measured: Callable[[Subject, Wanted], Mapping[str, str]] | None = None

    def whole(self, subject: Subject, options: Wanted) -> Made:
        """The file with all that is told of it."""
        made = self.make(subject, options)
        more = {} if self.measured is None else self.measured(subject, options)
        return Made(made.data, {**made.told, **more})

    def write(self, subject: Subject, options: Wanted) -> bytes:
        """The file's bytes."""
        return self.make(subject, options).data

    def adapted(self, given: Options) -> Wanted:
        """This format's options with what they share with another's and is not left open there."""
        own = {each.name for each in fields(self.options)}
        shared = {each.name: getattr(given, each.name) for each in fields(given)}
        told = {name: value for name, value in shared.items() if value is not None}
        return self.options(**{name: value for name, value in told.items() if name in own})


@dataclass(frozen=True)
class Exporter(FileFormat[Design, Wanted]):
    """A file format of a design.

    Attributes:
        placeable: whether a profile's points follow ``turn_deg`` and ``z_mm``.
        without_cam: whether it has something to write where no cam was found.
        the rest as of ``FileFormat``.
    """

    placeable: bool = True
    without_cam: bool = False


def untold(write: Callable[[Subject, Wanted], bytes]) -> Callable[[Subject, Wanted], Made]:
    """A file of which nothing is told."""

    def make(subject: Subject, options: Wanted) -> Made:
        return Made(write(subject, options))

    return make
