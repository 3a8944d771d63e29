"""Write openapi/openapi.json and the options of `camwright export`: `python -m service.openapi`."""

from __future__ import annotations

import json
from pathlib import Path

from service.app import create_app
from service.commands.export import OPTIONS, export_options
from service.settings import Settings

TARGET = Path(__file__).resolve().parents[1] / "openapi" / "openapi.json"


def openapi_text() -> str:
    """The OpenAPI document as text; the same on every machine."""
    document = create_app(Settings()).openapi()
    return json.dumps(document, indent=1, ensure_ascii=False, sort_keys=True) + "\n"


def options_text() -> str:
    """The options of `camwright export` as text."""
    return json.dumps(export_options(), indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    for target, text in ((TARGET, openapi_text()), (OPTIONS, options_text())):
        target.write_text(text, encoding="utf-8")
        print(f"{target} written.")
