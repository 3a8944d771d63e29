"""A file format: what it is called, what may be chosen, and how its file is made."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from importlib import resources
from typing import Any, Generic, Literal, TypeVar

import numpy as np

from synthesis.design.design import Design
from synthesis.exporters.options import Options
from synthesis.numerics.piecewise import Array

Subject = TypeVar("Subject")
Choice = TypeVar("Choice", bound=Options)


@dataclass(frozen=True)
class FileContent:
    """A file's bytes, and facts about it by the names of the HTTP headers that carry them.

    How far it is from the true curve for example: ``Curve-Error-Mm``.
    """

    data: bytes
    metadata: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class FileFormat(Generic[Subject, Choice]):
    """A file format of some subject. The same subject and options give the same bytes.

    Attributes:
        name: as in ``profile.{name}``. title: for people.
        media_type: for HTTP. extension: of the file, with its dot.
        make: subject and options to the file, as bytes alone where there is no metadata;
            InputError where there is no cam to write.
        options: what may be chosen; all of it has a default.
        purpose: what it is for, in a sentence; "" where the title says it.
        by_default: whether it is written where no formats are named.
        in_worker: whether it loads so much that a service has a worker make it.
        measure: further metadata that takes time to compute; None: there is none.
    """

    name: str
    title: str
    media_type: str
    extension: str
    make: Callable[[Subject, Choice], FileContent | bytes]
    options: type[Choice]
    purpose: str = ""
    by_default: bool = True
    in_worker: bool = False
    measure: Callable[[Subject, Choice], Mapping[str, str]] | None = None

    def content(self, subject: Subject, options: Choice) -> FileContent:
        """The file with all of its metadata."""
        made = self.make(subject, options)
        data, metadata = (made, {}) if isinstance(made, bytes) else (made.data, made.metadata)
        measured = {} if self.measure is None else self.measure(subject, options)
        return FileContent(data, {**metadata, **measured})

    def write(self, subject: Subject, options: Choice) -> bytes:
        """The file's bytes."""
        made = self.make(subject, options)
        return made if isinstance(made, bytes) else made.data

    def write_like(self, subject: Subject, given: Options) -> bytes:
        """The file's bytes, with options like another format's."""
        return self.write(subject, self.options_like(given))

    def options_like(self, given: Options) -> Choice:
        """This format's options with the values of another's that both have and are not None."""
        names = {each.name for each in fields(self.options)} & {each.name for each in fields(given)}
        values = {name: getattr(given, name) for name in names}
        return self.options(**{name: v for name, v in values.items() if v is not None})


@cache
def asset(name: str) -> str:
    """A file beside the code that is read or sent as it is: a page, a style, a table."""
    return (resources.files("synthesis.exporters") / "assets" / name).read_text("utf-8")


def format_rows(row: str, columns: Mapping[str, tuple[str, Array]]) -> str:
    """A row of text for each number of the columns, whose names stand in braces in ``row``.

    ``columns``: by name the format of a number, as ``%.3f``, and the numbers (n,).
    """
    names = re.findall(r"{(\w+)}", row)
    pattern = row.format(**{name: columns[name][0] for name in names})
    values = np.column_stack([columns[name][1] for name in names])
    return pattern * len(values) % tuple(values.ravel().tolist())


def compact_json(body: Mapping[str, Any]) -> bytes:
    """A JSON document without blanks, in UTF-8."""
    return json.dumps(body, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()


@dataclass(frozen=True)
class Exporter(FileFormat[Design, Choice]):
    """A file format of a design.

    ``placeable``: a profile's points follow ``turn_deg`` and ``z_mm``. ``without_cam``: there is a
    file of a design that found no cam.
    """

    placeable: bool = True
    without_cam: bool = False


_DESCRIBED = tomllib.loads(asset("formats.toml"))


def design_format(
    part: Literal["profile", "motion", "solid", "picture"],
    name: str,
    make: Callable[[Design, Choice], FileContent | bytes],
    options: type[Choice],
    measure: Callable[[Design, Choice], Mapping[str, str]] | None = None,
) -> Exporter[Choice]:
    """A format as ``assets/formats.toml`` describes it: title, media type, purpose and the rest."""
    fields = {"name": name, "extension": f".{name}", **_DESCRIBED[part][name]}
    return Exporter(make=make, options=options, measure=measure, **fields)


def machine_format(
    machine: Literal["spatial"],
    name: str,
    make: Callable[[Subject, Choice], FileContent | bytes],
    options: type[Choice],
) -> FileFormat[Subject, Choice]:
    """The same of a machine's answer; its extension is the end of the name."""
    fields = {"name": name, "extension": f".{name.rpartition('.')[2]}", **_DESCRIBED[machine][name]}
    return FileFormat(make=make, options=options, **fields)
