"""Pages for people: the studio, /docs and /redoc, with all assets served from here."""

from __future__ import annotations

import re
from pathlib import Path

import fastapi_swagger
from fastapi import APIRouter, FastAPI, Request, Response
from fastapi.openapi.docs import get_redoc_html
from fastapi.responses import HTMLResponse
from starlette.staticfiles import StaticFiles

from service import guide
from service.contract.documentation import OPENAPI_URL, TITLE

HERE = Path(__file__).resolve().parent
SWAGGER = Path(fastapi_swagger.__file__).resolve().parent / "resources"
ICON = "/assets/swagger/favicon-32x32.png"
# Nothing from other hosts, whatever the bundles try to load (ReDoc: a logo).
DOCS_POLICY = (
    "default-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; font-src 'self' data:; worker-src 'self' blob:; frame-ancestors 'self'"
)
REDOC_POLICY = f"{DOCS_POLICY}; script-src 'self' 'unsafe-inline'"
STUDIO_POLICY = "default-src 'self'; img-src 'self' data:; frame-ancestors 'self'"
INCLUDED = re.compile(r" *<!-- include: (\w+) -->\n")
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


def install(app: FastAPI) -> None:
    """Add the pages and their assets."""
    app.include_router(router)
    app.include_router(guide.router)
    for path, folder in (
        ("studio", HERE / "studio"),
        ("assets/swagger", SWAGGER),
        ("assets/docs", HERE / "assets" / "docs"),
        ("assets/redoc", HERE / "assets" / "redoc"),
    ):
        app.mount(f"/{path}", StaticFiles(directory=folder), name=path)
