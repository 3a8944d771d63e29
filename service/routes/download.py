"""Files of what is kept: named for every system, made in a thread, not sent twice."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from functools import partial

from fastapi import Request, Response

from service.storage.store import Row
from service.wire.etag import tag_of, unchanged
from service.wire.ranges import IN_PARTS
from synthesis.exporters import Made

SVG, PNG = "image/svg+xml", "image/png"
Make = Callable[[], Awaitable[Made]]
NOTHING_RUNS = "default-src 'none'; style-src 'unsafe-inline'"
# A page runs its own script, which its own policy names, and is of no origin: it can reach nothing.
ALONE = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src 'unsafe-inline'; "
    "frame-ancestors 'self'; sandbox allow-scripts"
)
POLICIES = {SVG: NOTHING_RUNS, PNG: NOTHING_RUNS, "text/html": ALONE}


@dataclass(frozen=True)
class Download:
    """A file as a browser gets it; ``ending`` follows the name that its owner gave."""

    ending: str
    media_type: str

    def headers(self, name: str) -> dict[str, str]:
        """Pictures and pages are shown (and reach nothing), everything else is saved."""
        file_name = f'filename="{stem_of(name)}-{self.ending}"'
        policy = POLICIES.get(self.media_type.partition(";")[0])
        if policy is None:
            return {"Content-Disposition": f"attachment; {file_name}"}
        return {
            "Content-Disposition": f"inline; {file_name}",
            "Content-Security-Policy": policy,
        }

    async def sent(
        self, request: Request, row: Row, made_by: tuple[str, ...], make: Make
    ) -> Response:
        """The file of a finished row, or 304; ``made_by`` decides on its bytes with the row."""
        tag = tag_of(row.etag or "", *made_by)
        known = unchanged(request, tag)
        if known is not None:
            return known
        made = await make()
        told = {f"Camwright-{name}": value for name, value in made.told.items()}
        return Response(
            made.data,
            headers={"ETag": f'"{tag}"', **IN_PARTS, **self.headers(row.name), **told},
            media_type=self.media_type,
        )


def in_thread(make: Callable[[], Made]) -> Make:
    """Made in a thread of this process."""
    return partial(asyncio.to_thread, make)


def stem_of(name: str) -> str:
    """What a file name begins with, in letters that every system takes."""
    return re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip("-.")[:60] or "cam"
