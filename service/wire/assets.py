"""What is the same for everybody: compressed once, and not sent to who has it."""

from __future__ import annotations

import gzip
from functools import lru_cache
from pathlib import Path

import anyio.to_thread
from starlette.datastructures import Headers
from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

from service.wire.conditional import not_modified

KEPT = 64  # compressed files; the pages have 59, of 1.5 MB compressed
KEPT_HEADERS = ("content-type", "last-modified", "etag")


class Assets(StaticFiles):
    """A folder of them.

    ``StaticFiles`` knows the tags of plain bytes alone: who has the compressed ones, which have
    tags of their own, was sent them again, compressed anew.
    """

    async def get_response(self, path: str, scope: Scope) -> Response:
        """The file, compressed where the caller takes that; 304 where he has it, in either form."""
        answer = await super().get_response(path, scope)
        if not isinstance(answer, FileResponse):
            return answer
        known = not_modified(Request(scope), answer.headers["etag"].strip('"'))
        if known is not None:
            return known
        text = answer.headers["content-type"].startswith(("text/", "image/svg+xml"))
        if not text or not takes_compressed(scope):
            return answer
        kept = {name: answer.headers[name] for name in KEPT_HEADERS}
        body = await anyio.to_thread.run_sync(_compressed, str(answer.path), kept["etag"])
        return compressed_response(body, kept)


def takes_compressed(scope: Scope) -> bool:
    """Whether the caller of a request takes compressed bytes."""
    return "gzip" in Headers(scope=scope).get("accept-encoding", "")


def compressed_response(body: bytes, headers: dict[str, str]) -> Response:
    """An answer whose bytes are compressed already: no middleware does it again."""
    return Response(
        body, headers={**headers, "content-encoding": "gzip", "vary": "Accept-Encoding"}
    )


@lru_cache(maxsize=KEPT)
def _compressed(path: str, _: str) -> bytes:
    """The bytes of a file; made anew when its tag has changed."""
    return gzip.compress(Path(path).read_bytes(), mtime=0)
