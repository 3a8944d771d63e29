"""Strong ETags: one for each sequence of bytes, compressed or not, and 304 where one matches."""

from __future__ import annotations

import hashlib
import re

from fastapi import Request, Response
from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from synthesis.design.identity import ENGINE_NUMBER

TAG = re.compile(r'(?:W/)?"([^"]*)"')
ENCODED = re.compile(r"-(?:gzip|br|zstd)$")


def tag_of(*parts: str | bytes) -> str:
    """A tag for what this engine makes from these parts alone."""
    digest = hashlib.sha256(str(ENGINE_NUMBER).encode())
    for part in parts:
        digest.update(part.encode() if isinstance(part, str) else part)
        digest.update(b"\0")
    return digest.hexdigest()[:32]


def not_modified(request: Request, tag: str) -> Response | None:
    """304 where the caller has these bytes already, otherwise None."""
    wanted = request.headers.get("if-none-match")
    if wanted is None:
        return None
    for known in TAG.findall(wanted):
        if ENCODED.sub("", known) == tag:
            return Response(status_code=304, headers={"ETag": f'"{known}"'})
    return Response(status_code=304, headers={"ETag": f'"{tag}"'}) if wanted == "*" else None


class TagEncodings:
    """Middleware around compression: compressed bytes have a tag of their own."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def tagged(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                encoding, tag = headers.get("content-encoding"), headers.get("etag")
                if encoding and tag:
                    headers["etag"] = f'{tag[:-1]}-{encoding}"'
            await send(message)

        await self._app(scope, receive, tagged)
