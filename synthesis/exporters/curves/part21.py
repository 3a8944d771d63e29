"""The clear text of STEP files (ISO 10303-21): entities, numbered in the order they are made."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol

NO_TIME = "1980-01-01T00:00:00"  # the same design, the same bytes: no clock
AUTHOR = "Camwright"


class Told(Protocol):
    """What a file tells of what it was made from."""

    @property
    def id(self) -> str:
        """Of the design."""

    @property
    def name(self) -> str:
        """That its owner gave it."""

    @property
    def engine_version(self) -> str:
        """Of what made it."""


class Entities:
    """Entities of a data section."""

    def __init__(self) -> None:
        self._lines: list[str] = []

    def add(self, kind: str, *attributes: str) -> str:
        """A simple entity; its reference, as ``#7``."""
        return self._added(f"{kind}({','.join(attributes)})")

    def add_complex(self, *parts: tuple[str, Sequence[str]]) -> str:
        """An entity of several types at once, by their names in alphabetical order."""
        told = [f"{kind}({','.join(given)})" for kind, given in parts]
        return self._added(f"({' '.join(told)})")

    def _added(self, text: str) -> str:
        self._lines.append(text)
        return f"#{len(self._lines)}"

    def lines(self) -> Iterable[str]:
        """The data section."""
        return (f"#{i}={text};" for i, text in enumerate(self._lines, start=1))


def exchange_file(design: Told, title: str, schema: str, data: Iterable[str]) -> bytes:
    """A whole file, which says what made it and from which design."""
    version = f"Camwright {design.engine_version}"
    lines = [
        "ISO-10303-21;",
        "HEADER;",
        f"FILE_DESCRIPTION(({text(title)},{text(f'design {design.id}')}),'2;1');",
        f"FILE_NAME({text(design.name or design.id)},'{NO_TIME}',(''),(''),{text(version)},"
        f"{text(version)},'');",
        f"FILE_SCHEMA(({text(schema)}));",
        "ENDSEC;",
        "DATA;",
        *data,
        "ENDSEC;",
        "END-ISO-10303-21;",
        "",
    ]
    return "\n".join(lines).encode("ascii")


def text(value: str) -> str:
    """A string: quotes and backslashes doubled, what is not ASCII by its code."""
    out = []
    for letter in value:
        if letter in "'\\":
            out.append(2 * letter)
        elif " " <= letter <= "~":
            out.append(letter)
        elif ord(letter) < 0x10000:
            out.append(f"\\X2\\{ord(letter):04X}\\X0\\")
        else:
            out.append(f"\\X4\\{ord(letter):08X}\\X0\\")
    return f"'{''.join(out)}'"


def real(value: float) -> str:
    """The shortest decimal number that reads back to the same double, with the point it needs."""
    mantissa, _, exponent = repr(float(value)).partition("e")
    point = "" if "." in mantissa else "."
    return f"{mantissa}{point}E{exponent}" if exponent else f"{mantissa}{point}"


def many(values: Iterable[str]) -> str:
    """A list."""
    return f"({','.join(values)})"
