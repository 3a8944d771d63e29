"""The guide at /guide: the project's documents as pages, without the internet.

Documents keep their places in the repository, so that a link between two of them works here as it
does there; links to what is not a document, such as a source file, become plain text.
"""

from __future__ import annotations

import html
from functools import lru_cache
from pathlib import Path
from string import Template
from typing import Final
from urllib.parse import urlsplit

from fastapi import APIRouter, HTTPException, Response
from fastapi.responses import FileResponse, HTMLResponse, RedirectResponse
from markdown_it import MarkdownIt
from markdown_it.token import Token

HERE: Final = Path(__file__).resolve().parent
# In a checkout the documents are beside the package, in an installation inside it.
ROOT: Final = HERE.parent if (HERE.parent / "docs" / "README.md").exists() else HERE / "documents"
START: Final = "docs/README.md"
AT_THE_TOP: Final = {"README.md", "CONTRIBUTING.md", "CHANGELOG.md"}
PICTURES: Final = {".svg", ".png"}
POLICY: Final = "default-src 'self'; style-src 'self' 'unsafe-inline'; frame-ancestors 'self'"
PAGE: Final = Template((HERE / "assets" / "guide" / "page.html").read_text(encoding="utf-8"))
router = APIRouter(include_in_schema=False)


@router.get("/guide")
async def show_index() -> Response:
    """To the index of all documents."""
    return RedirectResponse(f"/guide/{START}")


@router.get("/guide/{path:path}")
async def show_document(path: str) -> Response:
    """One document as a page, or one of its pictures."""
    file = _document(path)
    if file is None:
        raise HTTPException(404, f"The guide has no {path!r}; its index is /guide.")
    if file.suffix in PICTURES:
        return FileResponse(file)
    page = _page(file, file.stat().st_mtime_ns)
    return HTMLResponse(page, headers={"Content-Security-Policy": POLICY})


def _document(path: str) -> Path | None:
    """The file behind a path, if it is a document or a picture of one."""
    file = (ROOT / path).resolve()
    if not file.is_relative_to(ROOT) or not file.is_file():
        return None
    name = file.relative_to(ROOT).as_posix()
    known = name in AT_THE_TOP or (
        name.startswith("docs/") and (file.suffix == ".md" or file.suffix in PICTURES)
    )
    return file if known else None


@lru_cache(maxsize=64)
def _page(file: Path, _: int) -> str:
    """The page of a document; made anew when the file has changed."""
    parser = MarkdownIt("commonmark").enable("table")
    tokens = parser.parse(file.read_text(encoding="utf-8"))
    title = file.stem
    for position, token in enumerate(tokens):
        if token.type == "heading_open" and token.tag == "h1":
            title = tokens[position + 1].content
        if token.type == "heading_open":
            token.attrSet("id", _anchor(tokens[position + 1].content))
        _drop_dead_links(file, token)
    body = parser.renderer.render(tokens, parser.options, {})
    return PAGE.substitute(title=html.escape(title), body=body)


def _anchor(heading: str) -> str:
    """The id of a heading, as repositories make it: lower case, hyphens for blanks."""
    kept = "".join(c for c in heading.lower() if c.isalnum() or c in " -_")
    return kept.strip().replace(" ", "-")


def _drop_dead_links(file: Path, token: Token) -> None:
    """Make plain text of links to files that are not in the guide."""
    dead = False
    for child in token.children or ():
        if child.type == "link_open":
            target = urlsplit(str(child.attrGet("href") or ""))
            local = bool(target.path) and not target.scheme and not target.netloc
            there = (file.parent / target.path).resolve()
            name = there.relative_to(ROOT).as_posix() if there.is_relative_to(ROOT) else ""
            dead = local and not target.path.startswith("/") and _document(name or "-") is None
        if dead and child.type in ("link_open", "link_close"):
            closing, child.type, child.tag, child.nesting = child.type, "text", "", 0
            child.content = ""
            dead = closing == "link_open"
