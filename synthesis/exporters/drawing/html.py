"""Pages that stand alone: everything inside, nothing from elsewhere, no script but their own."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterable, Sequence
from html import escape
from itertools import repeat

from synthesis.exporters.drawing.canvas import COLUMN, FILLS, NOT_XML, SPACE
from synthesis.exporters.exporter import asset
from synthesis.exporters.options import Theme


def plain(text: str) -> str:
    """Any text as the content of an element or of a quoted attribute."""
    return escape(SPACE.sub(" ", NOT_XML.sub("\ufffd", text)).strip())


def plain_text(text: str) -> str:
    """Text of several lines, its blanks as they are."""
    return escape(NOT_XML.sub("\ufffd", text))


def table(
    head: Sequence[str], rows: Iterable[Sequence[str]], kinds: Iterable[str] = repeat("")
) -> str:
    """A table of texts; ``kinds``: of each row the class."""
    titles = "".join(f"<th>{plain(cell)}</th>" for cell in head)
    lines = "\n".join(
        f'<tr class="{kind}">' + "".join(f"<td>{plain(cell)}</td>" for cell in row) + "</tr>"
        for kind, row in zip(kinds, rows, strict=False)
    )
    return f"<table><thead><tr>{titles}</tr></thead><tbody>\n{lines}</tbody></table>"


def picture(drawing: bytes, text: str, width: int | None = None) -> str:
    """An SVG drawing as an image: its style touches nothing else on the page.

    Args:
        text: what is read out in place of it. width: in px, else its own.
    """
    size = "" if width is None else f' width="{width}"'
    data = base64.b64encode(drawing).decode()
    return f'<img alt="{plain(text)}"{size} src="data:image/svg+xml;base64,{data}">'


def page(title: str, style: str, body: str, theme: Theme, script: str = "") -> bytes:
    """A whole page; its policy lets in pictures that it holds, its style and its script alone."""
    policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
    run = ""
    if script:
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        policy += f"; script-src 'sha256-{digest}'"
        run = f"<script>{script}</script>\n"
    sheet = ground(theme) + style
    text = asset("page.html").format(
        policy=escape(policy), title=plain(title), style=sheet, body=body, run=run
    )
    return text.encode()


def ground(theme: Theme) -> str:
    """The page's own colours: those of the drawings."""
    light = _colours(COLUMN[theme])
    dark = f"@media screen and (prefers-color-scheme:dark){{{_colours(1)}}}"
    scheme = {"auto": "light dark", "dark": "dark"}.get(theme, "light")
    return f":root{{color-scheme:{scheme}}}{light}{dark if theme == 'auto' else ''}"


def _colours(column: int) -> str:
    ground, label, alarm = (FILLS[kind][column] for kind in ("ground", "label", "alarm"))
    wrong = f".broken strong,.broken td{{color:{alarm}}}"
    return f"body{{background:{ground};color:{label}}}{wrong}"
