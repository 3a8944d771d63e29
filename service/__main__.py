"""`python -m service`: start, check yourself, say where you are."""

from __future__ import annotations

from service.run import serve
from service.settings import Settings

if __name__ == "__main__":
    serve(Settings())
