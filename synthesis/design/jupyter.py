"""An answer that Jupyter shows; its pictures are drawn on a floor above, found by name."""

from __future__ import annotations

from importlib import import_module
from typing import Any


class ShownByJupyter:
    """Shown as ``synthesis.notebook_display`` says."""

    def _repr_mimebundle_(self, **_: Any) -> Any:
        """What is shown, by media type; as Jupyter asks for it."""
        return import_module("synthesis").notebook_display(self)
