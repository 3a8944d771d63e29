"""Write openapi/openapi.json: `python -m service.openapi`."""

from __future__ import annotations

import json
from pathlib import Path

from service.app import create_app
from service.settings import Settings

TARGET = Path(__file__).resolve().parents[1] / "openapi" / "openapi.json"


def openapi_text() -> str:
    """The OpenAPI document as text; the same on every machine."""
    document = create_app(Settings()).openapi()
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    TARGET.write_text(openapi_text(), encoding="utf-8")
    print(f"{TARGET} written.")
