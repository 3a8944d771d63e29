"""What a file of a linkage promises besides what every file does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from synthesis.exporters.exporter import FileFormat


@dataclass(frozen=True)
class LinkageFile(FileFormat[Any, Any]):
    """A file made from the answer about a linkage; its name is the file's own: ``motion.csv``.

    Attributes:
        suits: whether it can be made of an answer that has a linkage.
        the rest as of ``FileFormat``.
    """

    suits: Callable[[Any], bool] = lambda _: True
