"""Strong ETags: one for each sequence of bytes, compressed ones too, and 304 where they match."""

from __future__ import annotations

import hashlib
import re

from fastapi import Request, Response
from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

TAG = re.compile(r'(?:W/)?"([^"]*)"')
ENCODED = re.compile(r"-(?:gzip|br|zstd)$")


def tag_of(*parts: str | bytes) -> str:
    """A tag for what is made from these parts alone."""
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part.encode() if isinstance(part, str) else part)
        digest.update(b"\0")
    return digest.hexdigest()[:32]


def unchanged(request: Request, tag: str) -> Response | None:
    """304 where the caller has these bytes already, otherwise None."""
    wanted = request.headers.get("if-none-match")
    if wanted is None:
        return None
    for given in TAG.findall(wanted):
        if ENCODED.sub("", given) == tag:
            return Response(status_code=304, headers={"ETag": f'"{given}"'})
    return Response(status_code=304, headers={"ETag": f'"{tag}"'}) if wanted == "*" else None


class TagEncodings:
    """Outside of compression: the same design has other bytes when compressed, so another tag."""

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
