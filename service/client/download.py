"""Files, gone on with where a connection broke, in this process or in an earlier one."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import httpx2

from service.client.errors import ClientError
from service.client.retries import Retries, lost, pause_before_retry, refused
from service.client.wire import Asked, Opened, Wire

Told = Callable[[int, "int | None"], None]


@dataclass(frozen=True)
class Part:
    """The beginning of a file, beside where the file will be, and which bytes it is a part of."""

    target: Path
    request: str

    @property
    def file(self) -> Path:
        """What has come so far."""
        return self.target.with_name(f"{self.target.name}.part")

    @property
    def _note(self) -> Path:
        return self.target.with_name(f"{self.target.name}.part.json")

    def known(self) -> tuple[str, int]:
        """Strong ETag and number of the bytes there are; nothing where they cannot be used."""
        try:
            note = json.loads(self._note.read_text(encoding="utf-8"))
            size = self.file.stat().st_size
        except (OSError, ValueError):
            return "", 0
        same = note.get("request") == self.request
        return (note["etag"], size) if same and size else ("", 0)

    def begin(self, etag: str) -> None:
        """From the first byte on; without a strong ETag there is no going on later."""
        self.file.parent.mkdir(parents=True, exist_ok=True)
        self.forget_the_note()
        self.file.write_bytes(b"")
        if etag.startswith('"'):
            note = {"request": self.request, "etag": etag}
            self._note.write_text(json.dumps(note), encoding="utf-8")

    def add(self, chunk: bytes) -> None:
        """Some more bytes."""
        with self.file.open("ab") as file:
            file.write(chunk)

    def whole(self) -> Path:
        """It is all there: it becomes the file."""
        self.file.replace(self.target)
        self.forget_the_note()
        return self.target

    def forget_the_note(self) -> None:
        """The bytes cannot be gone on with any more."""
        self._note.unlink(missing_ok=True)


async def downloaded(
    wire: Wire, retries: Retries, asked: Asked, target: Path, told: Told | None = None
) -> Path:
    """The file at ``target``, which appears when it is whole.

    Until then the bytes are in ``target``.part; called again, it goes on with them if the service
    still has the same file (its strong ETag), and begins anew if not.

    Args:
        told: called with the bytes that are there, and of how many (None: not known).

    Raises:
        Refused, Unreachable: as for every call; every byte starts the count of tries anew.
        OSError: the file cannot be written.
    """
    part = Part(target, f"{wire.address}{asked.path}?{sorted(asked.query.items())}")
    tried = 0
    while True:
        tried += 1
        etag, have = part.known()
        resuming = {"Range": f"bytes={have}-", "If-Range": etag} if have else {}
        # Compressed on the way, the bytes would be counted differently from those that are kept.
        headers = {"Accept-Encoding": "identity", **resuming}
        try:
            async with wire.opened(replace(asked, headers=headers)) as opened:
                if opened.status < 400:
                    await _taken(part, opened, have, told)
                    return part.whole()
                if (
                    opened.status == 416
                    and opened.headers.get("content-range") == f"bytes */{have}"
                ):
                    return part.whole()
                answer = await opened.read()
        except httpx2.TransportError as error:
            if part.known()[1] > have:
                tried = 0
            elif tried >= retries.tries:
                raise lost(asked, error, tried) from error
            await wire.pause(retries.pause_s(max(tried, 1)))
        else:
            pause = pause_before_retry(retries, answer, tried)
            if pause is None:
                raise refused(answer)
            await wire.pause(pause)


async def _taken(part: Part, opened: Opened, have: int, told: Told | None) -> None:
    encoding = opened.headers.get("content-encoding", "identity")
    if encoding != "identity":
        raise ClientError(f"{part.request} came as {encoding}, though asked for as it is.")
    if opened.status != 206:
        part.begin(opened.headers.get("etag", ""))
        have = 0
    length = opened.headers.get("content-length")
    total = None if length is None else have + int(length)
    async for chunk in opened.chunks():
        part.add(chunk)
        have += len(chunk)
        if told is not None:
            told(have, total)
