"""Pages for people: /, /docs and /redoc, with every asset served from here."""

from __future__ import annotations

from pathlib import Path

import fastapi_swagger
from fastapi import APIRouter, FastAPI, Response
from fastapi.openapi.docs import get_redoc_html, get_swagger_ui_html
from fastapi.responses import HTMLResponse
from starlette.staticfiles import StaticFiles

from service.documentation import OPENAPI_URL, TITLE

HERE = Path(__file__).resolve().parent
SWAGGER = Path(fastapi_swagger.__file__).resolve().parent / "resources"
ICON = "/assets/swagger/favicon-32x32.png"
# Nothing from elsewhere, whatever the bundles would like to load (ReDoc: a logo).
POLICY = (
    "default-src 'self'; script-src 'self' 'unsafe-inline'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; font-src 'self' data:; worker-src 'self' blob:; frame-ancestors 'self'"
)
STUDIO_POLICY = "default-src 'self'; img-src 'self' data:; frame-ancestors 'self'"
SWAGGER_SETTINGS = {
    "syntaxHighlight": False,  # hangs near 1 MB of JSON
    "tryItOutEnabled": True,
    "displayRequestDuration": True,
    "filter": True,
    "defaultModelsExpandDepth": 0,
    "defaultModelExpandDepth": 4,
    "docExpansion": "list",
}

router = APIRouter(include_in_schema=False)


@router.get("/")
async def show_studio() -> Response:
    """The studio: a page that uses nothing but the public API."""
    return _studio("index.html")


@router.get("/spatial")
async def show_spatial_studio() -> Response:
    """The studio's page of spatial cams."""
    return _studio("spatial.html")


@router.get("/linkages")
async def show_linkage_studio() -> Response:
    """The studio's page of linkages."""
    return _studio("linkages.html")


def _studio(name: str) -> Response:
    page = (HERE / "studio" / name).read_bytes()
    return HTMLResponse(page, headers={"Content-Security-Policy": STUDIO_POLICY})


@router.get("/docs")
async def show_swagger() -> Response:
    """Swagger UI."""
    page = get_swagger_ui_html(
        openapi_url=OPENAPI_URL,
        title=f"{TITLE}: try it",
        swagger_js_url="/assets/swagger/swagger-ui-bundle.js",
        swagger_css_url="/assets/swagger/swagger-ui.css",
        swagger_favicon_url=ICON,
        swagger_ui_parameters=SWAGGER_SETTINGS,
    )
    return _page(bytes(page.body))


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
    return _page(bytes(page.body))


def _page(html: bytes) -> Response:
    return HTMLResponse(html, headers={"Content-Security-Policy": POLICY})


def install(app: FastAPI) -> None:
    """Add the pages and their assets."""
    app.include_router(router)
    app.mount("/studio", StaticFiles(directory=HERE / "studio"), name="studio")
    app.mount("/assets/swagger", StaticFiles(directory=SWAGGER), name="swagger")
    app.mount("/assets/redoc", StaticFiles(directory=HERE / "assets" / "redoc"), name="redoc")
