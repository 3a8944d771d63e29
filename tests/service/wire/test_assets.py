"""Files of the pages: sent compressed, made once, and not again to who has them in either form."""

from __future__ import annotations

import gzip
import zlib
from pathlib import Path

import httpx2
import pytest

from service.wire import assets

SCRIPT = "/assets/docs/docs.js"
STYLE = "/assets/swagger/swagger-ui.css"
CONTRACT = "/openapi.json"


def test_who_has_a_file_compressed_or_plain_is_not_sent_it_again(client: httpx2.Client) -> None:
    plain = client.get(SCRIPT, headers={"Accept-Encoding": "identity"})
    packed = client.get(SCRIPT, headers={"Accept-Encoding": "br, gzip"})
    assert "content-encoding" not in plain.headers
    assert packed.headers["content-encoding"] == "gzip"
    assert packed.headers["vary"].lower() == "accept-encoding"
    assert packed.headers["etag"] != plain.headers["etag"]
    assert packed.content == plain.content
    for answer in (plain, packed):
        again = client.get(SCRIPT, headers={"If-None-Match": answer.headers["etag"]})
        assert (again.status_code, again.content) == (304, b"")
        assert again.headers["etag"] == answer.headers["etag"]
        since = {"If-Modified-Since": answer.headers["last-modified"]}
        assert client.get(SCRIPT, headers=since).status_code == 304
    assert client.get(SCRIPT, headers={"If-None-Match": '"other"'}).status_code == 200
    head = client.head(SCRIPT, headers={"Accept-Encoding": "gzip"})
    assert (head.status_code, head.content) == (200, b"")


@pytest.mark.parametrize("path", [STYLE, CONTRACT])
def test_it_is_compressed_once(
    path: str, client: httpx2.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = client.get(path, headers={"Accept-Encoding": "gzip"})
    monkeypatch.setattr(gzip, "compress", None)  # to compress anything would fail
    monkeypatch.setattr(zlib, "compressobj", None)  # by which the middleware does it
    again = client.get(path, headers={"Accept-Encoding": "gzip"})
    assert (again.status_code, again.content) == (200, first.content)
    assert again.headers["content-encoding"] == "gzip"


def test_it_is_made_anew_when_the_file_has_changed(tmp_path: Path) -> None:
    file = tmp_path / "a.js"
    file.write_text("old")
    assert gzip.decompress(assets._compressed(str(file), "1")) == b"old"
    file.write_text("new")
    assert gzip.decompress(assets._compressed(str(file), "2")) == b"new"


def test_pictures_and_what_is_not_there_stay_as_they_are(client: httpx2.Client) -> None:
    picture = client.get("/assets/swagger/favicon-32x32.png", headers={"Accept-Encoding": "gzip"})
    assert picture.content[:4] == b"\x89PNG"
    assert "content-encoding" not in picture.headers
    assert client.get("/assets/swagger/none.js").status_code == 404
