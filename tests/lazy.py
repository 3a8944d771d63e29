"""Libraries that take a second or more to load: collecting tests does without them."""

from __future__ import annotations

import importlib
from typing import Any


class LazyModule:
    """A module whose names and submodules are attributes; it is imported at the first use of one.

    Args:
        name: of the module, with dots.
    """

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):  # pytest looks for marks in whatever a test module holds
            raise AttributeError(name)
        module = importlib.import_module(self._name)
        if hasattr(module, name):
            return getattr(module, name)
        return importlib.import_module(f"{self._name}.{name}")
