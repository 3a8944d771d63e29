"""What every file of a linkage promises."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from synthesis.exporters.options import Options


@dataclass(frozen=True)
class LinkageFile:
    """A file made from the answer about a linkage. The same answer and options, the same bytes.

    Attributes:
        name: of the file, as in ``motion.csv``. title: for people. media_type: for HTTP.
        write: answer and options to its bytes. options: what may be chosen.
        purpose: what it is for; "" where the title says it.
    """

    name: str
    title: str
    media_type: str
    write: Callable[[Any, Any], bytes]
    options: type[Options]
    purpose: str = ""
