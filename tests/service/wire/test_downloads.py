"""Files in parts: what the service cuts, and how the client goes on with what it has."""

from __future__ import annotations

import asyncio
import hashlib
from pathlib import Path

import httpx2
import pytest

from service.client import AsyncClient, Client, Refused, Retries, Unreachable
from tests.service.conftest import Running
from tests.service.cutting import Cutting
from tests.service.fake_core import Gate
from tests.service.sweeps.test_sweeps import over, posted, sweep_of
from tests.service.workers.test_trouble import is_problem

QUICK = Retries(tries=3, first_s=0.01)


@pytest.fixture(scope="module")
def table(service: Running) -> str:
    """A file of some tens of kilobytes that is written anew for each request."""
    where = posted(service.client, sweep_of([f"{i} of a long table" for i in range(450)]))
    over(service.client, where)
    return f"{where}/items.csv"


@pytest.fixture(scope="module")
def whole(service: Running, table: str) -> httpx2.Response:
    return service.client.get(table, headers={"Accept-Encoding": "identity"})


@pytest.mark.parametrize(
    ("question", "first", "last"),
    [("0-0", 0, 0), ("7-1234", 7, 1234), ("20001-", 20001, None), ("-77", -77, None),
     ("5-99999999", 5, None)],
)  # fmt: skip
def test_a_part_is_what_the_whole_has_there(
    client: httpx2.Client, table: str, whole: httpx2.Response, question: str, first: int,
    last: int | None,
) -> None:  # fmt: skip
    for suffix in ("csv", "parquet"):
        path = table.replace("csv", suffix)
        all_of_it = client.get(path, headers={"Accept-Encoding": "identity"}).content
        part = client.get(path, headers={"Range": f"bytes={question}"})
        assert part.status_code == 206
        expected = all_of_it[first : None if last is None else last + 1]
        assert part.content == expected
        start = first if first >= 0 else len(all_of_it) + first
        span = f"bytes {start}-{start + len(expected) - 1}/{len(all_of_it)}"
        assert part.headers["content-range"] == span
        assert int(part.headers["content-length"]) == len(expected)
        assert "content-encoding" not in part.headers
    assert whole.headers["accept-ranges"] == "bytes"


def test_a_part_of_another_file_is_not_given(
    client: httpx2.Client, table: str, whole: httpx2.Response
) -> None:
    tag = whole.headers["etag"]
    same = {"Range": "bytes=9-", "If-Range": tag}
    assert client.get(table, headers=same).status_code == 206
    for other in ('"another"', f"W/{tag}", "Wed, 21 Oct 2015 07:28:00 GMT"):
        answer = client.get(table, headers={"Range": "bytes=9-", "If-Range": other})
        assert (answer.status_code, answer.content) == (200, whole.content)


def test_what_is_beyond_the_end_or_no_range_at_all(
    client: httpx2.Client, table: str, whole: httpx2.Response
) -> None:
    size = len(whole.content)
    for beyond in (f"{size}-", "-0", "9-3"):
        answer = client.get(table, headers={"Range": f"bytes={beyond}"})
        is_problem(answer, 416, "no-such-bytes")
        assert answer.headers["content-range"] == f"bytes */{size}"
    for nonsense in ("bytes=-", "bytes=a-b", "bytes=0-1,5-6", "lines=1-2", "bytes=-1-3"):
        answer = client.get(table, headers={"Range": nonsense})
        assert answer.content == whole.content or answer.status_code == 416


def test_only_what_stays_the_same_is_had_in_parts(client: httpx2.Client, tmp_path: Path) -> None:
    where = posted(client, sweep_of(Gate(tmp_path / "gate").names(40)))
    running = client.get(f"{where}/items.csv", headers={"Range": "bytes=3-"})
    assert (running.status_code, "etag" in running.headers) == (200, False)
    client.delete(where)
    assert client.get(f"{where}/items.csv", headers={"Range": "bytes=3-"}).status_code == 206
    unaffected = client.get(where, headers={"Range": "bytes=3-9"})
    assert unaffected.status_code == 200
    assert unaffected.json()["state"] == "dismissed"


def test_a_table_that_is_known_is_not_sent_again(
    client: httpx2.Client, table: str, whole: httpx2.Response
) -> None:
    answer = client.get(table, headers={"If-None-Match": whole.headers["etag"]})
    assert (answer.status_code, answer.content) == (304, b"")


def test_a_download_survives_broken_connections(
    service: Running, table: str, whole: httpx2.Response, tmp_path: Path
) -> None:
    reports: list[tuple[int, int | None]] = []
    target, cuts = tmp_path / "items.csv", [9000, 6000, 0, 4000]
    with Cutting(service.url, cuts) as between, Client(between.url, retries=QUICK) as client:
        client.download(table, target, progress=lambda *now: reports.append(now))
    assert target.read_bytes() == whole.content
    assert [entry.name for entry in tmp_path.iterdir()] == ["items.csv"]
    question = [request.lower() for request in between.requests]
    assert len(question) == 5
    assert b"range:" not in question[0]
    assert all(b"if-range:" in request for request in question[1:])
    have = [now for now, _ in reports]
    assert have == sorted(have)
    assert reports[-1] == (len(whole.content), len(whole.content))


def test_a_later_program_goes_on_where_an_earlier_one_gave_up(
    service: Running, table: str, whole: httpx2.Response, tmp_path: Path
) -> None:
    target, size = tmp_path / "items.csv", len(whole.content)
    with Cutting(service.url, [15000, 0, 0, 0]) as between:
        with Client(between.url, retries=QUICK) as client, pytest.raises(Unreachable):
            client.download(table, target)
        assert not target.exists()
        have = (tmp_path / "items.csv.part").stat().st_size
        assert 10000 < have < 15000

        async def later() -> None:
            async with AsyncClient(between.url) as client:
                await client.download(table, target)

        asyncio.run(later())
        assert f"bytes={have}-".encode() in between.requests[-1]
    assert hashlib.sha256(target.read_bytes()).digest() == hashlib.sha256(whole.content).digest()
    assert size == target.stat().st_size


def test_a_part_of_what_is_there_no_more_is_begun_anew(
    service: Running, table: str, whole: httpx2.Response, tmp_path: Path
) -> None:
    target = tmp_path / "items.csv"
    cuts = [15000, 0, 0, 0]
    with Cutting(service.url, cuts) as between, Client(between.url, retries=QUICK) as client:
        with pytest.raises(Unreachable):
            client.download(table, target)
        note = tmp_path / "items.csv.part.json"
        note.write_text(note.read_text().replace(whole.headers["etag"].strip('"'), "0" * 32))
        (tmp_path / "items.csv.part").write_bytes(b"of another table" * 600)
        client.download(table, target)
    assert target.read_bytes() == whole.content


def test_a_part_that_is_all_there_is_the_file(
    service: Running, table: str, whole: httpx2.Response, tmp_path: Path
) -> None:
    """The program ended between the last byte and the file's own name."""
    target = tmp_path / "items.csv"
    with Cutting(service.url, [15000, 0, 0]) as between:
        with Client(between.url, retries=Retries(tries=2, first_s=0.01)) as client:
            with pytest.raises(Unreachable):
                client.download(table, target)
            (tmp_path / "items.csv.part").write_bytes(whole.content)
            client.download(table, target)
        assert f"bytes={len(whole.content)}-".encode() in between.requests[-1]
    assert target.read_bytes() == whole.content


def test_what_there_is_not_leaves_no_file(service: Running, tmp_path: Path) -> None:
    with Client(service.url) as client, pytest.raises(Refused, match="no design"):
        client.download("/v1/designs/none/profile.csv", tmp_path / "profile.csv")
    assert not list(tmp_path.iterdir())
