"""Downloads that continue after a lost connection, in this process or in a later one."""

from __future__ import annotations

import json
from collections.abc import AsyncGenerator, Callable
from dataclasses import dataclass, replace
from pathlib import Path

import httpx2

from service.client.exchange import ClientError, Exchange, Request

ProgressCallback = Callable[[int, "int | None"], None]


@dataclass(frozen=True)
class Part:
    """The beginning of a file, next to the target, and a note on which file it is a part of."""

    target: Path
    request: str

    @property
    def file(self) -> Path:
        """The bytes received so far."""
        return self.target.with_name(f"{self.target.name}.part")

    @property
    def _note(self) -> Path:
        return self.target.with_name(f"{self.target.name}.part.json")

    def received(self) -> tuple[str, int]:
        """Strong ETag and number of the bytes received; ("", 0) where they cannot be used."""
        try:
            note = json.loads(self._note.read_text(encoding="utf-8"))
            size = self.file.stat().st_size
        except (OSError, ValueError):
            return "", 0
        same = note.get("request") == self.request
        return (note["etag"], size) if same and size else ("", 0)

    def begin(self, etag: str) -> None:
        """Begin with the first byte; without a strong ETag it cannot be continued later."""
        self.file.parent.mkdir(parents=True, exist_ok=True)
        self.delete_note()
        self.file.write_bytes(b"")
        if etag.startswith('"'):
            note = {"request": self.request, "etag": etag}
            self._note.write_text(json.dumps(note), encoding="utf-8")

    def complete(self) -> Path:
        """Rename it to the target."""
        self.file.replace(self.target)
        self.delete_note()
        return self.target

    def delete_note(self) -> None:
        """Make the bytes unusable for continuation."""
        self._note.unlink(missing_ok=True)

    def is_whole(self, response: httpx2.Response) -> bool:
        """Whether a response says that nothing is left of the file to be sent."""
        span = response.headers.get("content-range")
        return response.status_code == 416 and span == f"bytes */{self.received()[1]}"

    async def receive(
        self, response: httpx2.Response
    ) -> AsyncGenerator[tuple[int, int | None], None]:
        """Append the bytes of a response; after each chunk, the bytes so far and in all."""
        if self.is_whole(response):
            return
        (etag, have), headers = self.received(), response.headers
        encoding = headers.get("content-encoding", "identity")
        if encoding != "identity":
            raise ClientError(
                f"{self.request} was sent as {encoding}, though requested without encoding."
            )
        if response.status_code != 206:
            self.begin(headers.get("etag", ""))
            have = 0
        else:  # the bytes have to be those that were requested
            span = headers.get("content-range", "")
            if not (headers.get("etag") == etag and span.startswith(f"bytes {have}-")):
                self.delete_note()
                raise httpx2.RemoteProtocolError(f"another range ({span}) than requested")
        length = headers.get("content-length")
        total = None if length is None else have + int(length)
        async for chunk in response.aiter_raw():
            with self.file.open("ab") as file:
                file.write(chunk)
            have += len(chunk)
            yield have, total


async def download(
    exchange: Exchange, request: Request, target: Path, progress: ProgressCallback | None = None
) -> Path:
    """Download a file to ``target``, which appears when it is complete.

    Until then the bytes are in ``target``.part; called again, it continues with them if the service
    still has the same file (its strong ETag), and begins anew if not.

    Args:
        progress: called with the bytes received, and the total (None: unknown).

    Raises:
        Refused, Unreachable: as for every call; every byte resets the number of tries.
        OSError: the file cannot be written.
    """
    query = sorted(request.query.items())
    part = Part(target, f"{exchange.http.base_url}{request.path}?{query}")

    def next_request() -> Request:
        etag, have = part.received()
        resuming = {"Range": f"bytes={have}-", "If-Range": etag} if have else {}
        # Ranges count bytes of the uncompressed file.
        return replace(request, headers={"Accept-Encoding": "identity", **resuming})

    async for have, total in exchange.receive(
        next_request, part.receive, lambda r: r.status_code < 400 or part.is_whole(r)
    ):
        if progress is not None:
            progress(have, total)
    return part.complete()
