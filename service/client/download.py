"""Downloads that continue after a lost connection, in this process or in a later one."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import httpx2

from service.client.errors import ClientError
from service.client.retries import Retries, pause_before_retry, refused, unreachable
from service.client.transport import Request, ResponseStream, Transport

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

    def add(self, chunk: bytes) -> None:
        """Append bytes."""
        with self.file.open("ab") as file:
            file.write(chunk)

    def complete(self) -> Path:
        """Rename it to the target."""
        self.file.replace(self.target)
        self.delete_note()
        return self.target

    def delete_note(self) -> None:
        """Make the bytes unusable for continuation."""
        self._note.unlink(missing_ok=True)


async def download(
    transport: Transport,
    retries: Retries,
    request: Request,
    target: Path,
    progress: ProgressCallback | None = None,
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
    part = Part(target, f"{transport.address}{request.path}?{sorted(request.query.items())}")
    tried = 0
    while True:
        tried += 1
        etag, have = part.received()
        resuming = {"Range": f"bytes={have}-", "If-Range": etag} if have else {}
        # Ranges count bytes of the uncompressed file.
        headers = {"Accept-Encoding": "identity", **resuming}
        try:
            async with transport.stream(replace(request, headers=headers)) as response:
                if response.status < 400:
                    _check(part, response, etag, have)
                    await _receive(part, response, have, progress)
                    return part.complete()
                if (
                    response.status == 416
                    and response.headers.get("content-range") == f"bytes */{have}"
                ):
                    return part.complete()
                answer = await response.read()
        except httpx2.TransportError as error:
            if part.received()[1] > have:
                tried = 0
            elif tried >= retries.tries:
                raise unreachable(request, error, tried) from error
            await transport.pause(retries.pause_s(max(tried, 1)))
        else:
            pause = pause_before_retry(retries, answer, tried)
            if pause is None:
                raise refused(answer)
            await transport.pause(pause)


def _check(part: Part, response: ResponseStream, etag: str, have: int) -> None:
    """Check that the bytes that follow are those requested."""
    encoding = response.headers.get("content-encoding", "identity")
    if encoding != "identity":
        raise ClientError(
            f"{part.request} was sent as {encoding}, though requested without encoding."
        )
    span, tag = response.headers.get("content-range", ""), response.headers.get("etag")
    if response.status == 206 and not (tag == etag and span.startswith(f"bytes {have}-")):
        part.delete_note()
        raise httpx2.RemoteProtocolError(f"another range ({span}) than requested")


async def _receive(
    part: Part, response: ResponseStream, have: int, progress: ProgressCallback | None
) -> None:
    if response.status != 206:
        part.begin(response.headers.get("etag", ""))
        have = 0
    length = response.headers.get("content-length")
    total = None if length is None else have + int(length)
    async for chunk in response.chunks():
        part.add(chunk)
        have += len(chunk)
        if progress is not None:
            progress(have, total)
