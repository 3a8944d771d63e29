"""`python -m service`: start, check yourself, say where you are."""

from __future__ import annotations

from service.run import serve
from service.settings import settings_from

if __name__ == "__main__":
    serve(settings_from())
