"""Pages for people: the studio, /docs, /redoc and the guide, with all assets served from here.

The guide is the project's documents as pages. They keep their places in the repository, so that a
link between two of them works here as it does there; links to what is not a document, such as a
source file, become plain text.
"""

from __future__ import annotations

import asyncio
import gzip
import html
import json
import re
from functools import lru_cache
from importlib.metadata import distribution
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import urlsplit

from fastapi import APIRouter, FastAPI, HTTPException, Request, Response
from fastapi.openapi.docs import get_redoc_html
from fastapi.responses import FileResponse, HTMLResponse, JSONResponse, RedirectResponse

from service.contract.documentation import OPENAPI_URL, TITLE
from service.state import Parts
from service.wire.access import COOKIE, SESSION, KeyRefused, key_of, refusal
from service.wire.assets import Assets, compressed_response, takes_compressed
from service.wire.conditional import not_modified, tag_of

if TYPE_CHECKING:
    from markdown_it.token import Token

HERE = Path(__file__).resolve().parent
# To import the package takes as long as half of the web framework.
SWAGGER = Path(str(distribution("fastapi-swagger").locate_file("fastapi_swagger/resources")))
ICON = "/assets/swagger/favicon-32x32.png"
# Nothing from other hosts, whatever the bundles try to load (ReDoc: a logo).
DOCS_POLICY = (
    "default-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; font-src 'self' data:; worker-src 'self' blob:; frame-ancestors 'self'"
)
REDOC_POLICY = f"{DOCS_POLICY}; script-src 'self' 'unsafe-inline'"
STUDIO_POLICY = "default-src 'self'; img-src 'self' data:; frame-ancestors 'self'"
INCLUDED = re.compile(r" *<!-- include: (\w+) -->\n")
# In a checkout the documents are beside the package, in an installation inside it.
DOCUMENTS = HERE.parent if (HERE.parent / "docs" / "README.md").exists() else HERE / "documents"
FIRST_DOCUMENT = "docs/README.md"
AT_THE_TOP = {"README.md", "CONTRIBUTING.md", "CHANGELOG.md"}
PICTURES = {".svg", ".png"}
GUIDE_POLICY = "default-src 'self'; style-src 'self' 'unsafe-inline'; frame-ancestors 'self'"
GUIDE_PAGE = Template((HERE / "assets" / "guide" / "page.html").read_text(encoding="utf-8"))
router = APIRouter(include_in_schema=False)


@router.get("/")
@router.get("/spatial")
@router.get("/linkages")
async def show_studio(request: Request) -> Response:
    """A page of the studio, which uses the public API alone, with the parts that all share."""
    name = request.url.path.removeprefix("/") or "index"
    page = INCLUDED.sub(lambda found: _html("parts", found[1]), _html(name))
    return HTMLResponse(page, headers={"Content-Security-Policy": STUDIO_POLICY})


def _html(*names: str) -> str:
    return (HERE / "studio" / Path(*names)).with_suffix(".html").read_text("utf-8")


@router.post(SESSION)
async def keep_key(request: Request, parts: Parts) -> Response:
    """Let a browser keep the key that it sends in Authorization as a cookie, until it is closed.

    What it loads by itself, such as pictures, downloads and events, has no other way to bring one.
    No script can read the cookie, and no request that another site has caused brings it along.
    """
    key = key_of(request.headers) if "authorization" in request.headers else ""
    try:
        caller = await parts.keys.caller(key or "")
    except KeyRefused as error:
        raise refusal(f"The key {error}.", ', error="invalid_token"') from None
    answer = JSONResponse({"owner": caller.owner}, headers={"Cache-Control": "no-store"})
    secure = request.url.scheme == "https"
    answer.set_cookie(COOKIE, key or "", httponly=True, samesite="strict", secure=secure)
    return answer


@router.delete(SESSION, status_code=204)
async def forget_key() -> Response:
    """Let the browser forget the key."""
    answer = Response(status_code=204)
    answer.delete_cookie(COOKIE, httponly=True, samesite="strict")
    return answer


@router.get("/docs")
async def show_swagger() -> Response:
    """Swagger UI."""
    page = (HERE / "assets" / "docs" / "docs.html").read_bytes()
    return HTMLResponse(page, headers={"Content-Security-Policy": DOCS_POLICY})


@router.get("/redoc")
async def show_redoc() -> Response:
    """ReDoc."""
    page = get_redoc_html(
        openapi_url=OPENAPI_URL,
        title=f"{TITLE}: reference",
        redoc_js_url="/assets/redoc/redoc.standalone.js",
        redoc_favicon_url=ICON,
        with_google_fonts=False,
    )
    return HTMLResponse(bytes(page.body), headers={"Content-Security-Policy": REDOC_POLICY})


@router.get(OPENAPI_URL)
async def show_contract(request: Request) -> Response:
    """The OpenAPI document."""
    document = await contract(request.app)
    known = not_modified(request, document.tag)
    if known is not None:
        return known
    headers = {"ETag": f'"{document.tag}"', "content-type": "application/json"}
    if takes_compressed(request.scope):
        return compressed_response(document.compressed, headers)
    return Response(document.plain, headers=headers)


class Contract(NamedTuple):
    """The OpenAPI document in both forms, and its tag."""

    plain: bytes
    compressed: bytes
    tag: str


async def contract(app: FastAPI) -> Contract:
    """The OpenAPI document.

    Made once; who asks meanwhile waits for the same task, which goes on when one of them leaves.
    """
    if not hasattr(app.state, "contract"):
        app.state.contract = asyncio.create_task(_make_contract(app))
    made: Contract = await asyncio.shield(app.state.contract)
    return made


async def _make_contract(app: FastAPI) -> Contract:
    """In a thread, for it takes more than a second, and not beside the other one that builds
    schemas: each silences warnings for a while, and would end the other's silence.
    """
    await app.state.preparing
    return await asyncio.to_thread(_contract, app)


def _contract(app: FastAPI) -> Contract:
    text = json.dumps(app.openapi(), ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return Contract(text.encode(), gzip.compress(text.encode(), mtime=0), tag_of(text))


@router.get("/guide")
async def show_index() -> Response:
    """To the index of all documents."""
    return RedirectResponse(f"/guide/{FIRST_DOCUMENT}")


@router.get("/guide/{path:path}")
async def show_document(path: str) -> Response:
    """One document as a page, or one of its pictures."""
    file = _document(path)
    if file is None:
        raise HTTPException(404, f"The guide has no {path!r}; its index is /guide.")
    if file.suffix in PICTURES:
        return FileResponse(file)
    page = _page(file, file.stat().st_mtime_ns)
    return HTMLResponse(page, headers={"Content-Security-Policy": GUIDE_POLICY})


def _document(path: str) -> Path | None:
    """The file behind a path, if it is a document or a picture of one."""
    try:
        file = (DOCUMENTS / path).resolve()
        if not file.is_relative_to(DOCUMENTS) or not file.is_file():
            return None
    except (OSError, ValueError):  # no system has such a name: it is too long, or holds a NUL
        return None
    name = file.relative_to(DOCUMENTS).as_posix()
    known = name in AT_THE_TOP or (
        name.startswith("docs/") and (file.suffix == ".md" or file.suffix in PICTURES)
    )
    return file if known else None


@lru_cache(maxsize=64)
def _page(file: Path, _: int) -> str:
    """The page of a document; made anew when the file has changed."""
    from markdown_it import MarkdownIt  # few who start the service read the guide

    parser = MarkdownIt("commonmark").enable("table")
    tokens = parser.parse(file.read_text(encoding="utf-8"))
    title = file.stem
    for position, token in enumerate(tokens):
        if token.type == "heading_open":
            heading = tokens[position + 1].content
            title = heading if token.tag == "h1" else title
            # The id of a heading, as repositories make it: lower case, hyphens for blanks.
            kept = "".join(c for c in heading.lower() if c.isalnum() or c in " -_")
            token.attrSet("id", kept.strip().replace(" ", "-"))
        _drop_dead_links(file, token)
    body = parser.renderer.render(tokens, parser.options, {})
    return GUIDE_PAGE.substitute(title=html.escape(title), body=body)


def _drop_dead_links(file: Path, token: Token) -> None:
    """Make plain text of links to files that are not in the guide."""
    dead = False
    for child in token.children or ():
        if child.type == "link_open":
            target = urlsplit(str(child.attrGet("href") or ""))
            local = bool(target.path) and not target.scheme and not target.netloc
            there = (file.parent / target.path).resolve()
            name = (
                there.relative_to(DOCUMENTS).as_posix() if there.is_relative_to(DOCUMENTS) else ""
            )
            dead = local and not target.path.startswith("/") and _document(name or "-") is None
        if dead and child.type in ("link_open", "link_close"):
            closing, child.type, child.tag, child.nesting = child.type, "text", "", 0
            child.content = ""
            dead = closing == "link_open"


def install(app: FastAPI) -> None:
    """Add the pages and their assets."""
    app.include_router(router)
    for path, folder in (
        ("studio", HERE / "studio"),
        ("assets/swagger", SWAGGER),
        ("assets/docs", HERE / "assets" / "docs"),
        ("assets/redoc", HERE / "assets" / "redoc"),
    ):
        app.mount(f"/{path}", Assets(directory=folder), name=path)
