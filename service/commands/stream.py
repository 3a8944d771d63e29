"""JSON documents out of a pipe, one after the other, as soon as each is complete."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator


def documents(lines: Iterable[bytes]) -> Iterator[bytes]:
    """The documents of JSON lines, or of JSON written over several lines.

    A line that ends a document ends it; one that cannot be the beginning of a document is given as
    it is, for whoever reads it to say what is wrong. What an incomplete document is followed by is
    read on its own where it can be, so that one wrong line costs no other.
    """
    gathered = b""
    for line in lines:
        if not gathered and not line.strip():
            continue
        before, gathered = gathered, gathered + line
        # A document over several lines ends with a bracket: others need not be read yet, which
        # keeps the work for a long one from growing with the square of its lines.
        if before and line.rstrip()[-1:] not in (b"}", b"]"):
            continue
        if not _may_continue(gathered):
            if before and _is_whole(line) and not _is_whole(gathered):
                yield before
                yield line
            else:
                yield gathered
            gathered = b""
    if gathered:
        yield gathered


def _may_continue(text: bytes) -> bool:
    """Whether further lines may make a document of it: it is wrong at its very end, if at all."""
    try:
        json.loads(text)
    except json.JSONDecodeError as error:
        return error.pos >= len(error.doc.rstrip()) and error.msg != "Extra data"
    except ValueError:
        return False
    return False


def _is_whole(text: bytes) -> bool:
    try:
        json.loads(text)
    except ValueError:
        return False
    return True
