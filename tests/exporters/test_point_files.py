"""IBL, SLDCRV and XLSX, read back by parsers that know the format only."""

from __future__ import annotations

import io
import zipfile
from typing import Any

import numpy as np
import pytest

from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters import PROFILE_FORMATS
from tests.exporters.test_points import points


def written(name: str, design: Design, **options: Any) -> bytes:
    exporter = PROFILE_FORMATS[name]
    return exporter.write(design, exporter.options(**options))


def from_ibl(data: bytes) -> tuple[str, list[np.ndarray]]:
    """Whether it is open or closed, and the rows of every section."""
    ends, how, *lines = data.decode("ascii").splitlines()
    assert how == "arclength"
    sections: list[list[list[str]]] = []
    place = 0
    while place < len(lines):
        k = len(sections) + 1
        assert lines[place : place + 2] == [f"begin section ! {k}", f"begin curve ! {k}"]
        place += 2
        rows = []
        while place < len(lines) and not lines[place].startswith("begin"):
            rows.append(lines[place].split())
            place += 1
        assert [int(row[0]) for row in rows] == list(range(1, len(rows) + 1))
        sections.append(rows)
    return ends, [np.array(rows, float)[:, 1:] for rows in sections]


def from_sldcrv(data: bytes) -> np.ndarray:
    text = data.decode("ascii")
    assert text.count("\n") == text.count("\r\n")
    assert text.endswith("\r\n")
    rows = [line.split("\t") for line in text.removesuffix("\r\n").split("\r\n")]
    for row in rows:
        assert len(row) == 3
        assert all(cell.endswith("mm") and len(cell.split(".")[1]) == 12 for cell in row)
    return np.array([[float(cell.removesuffix("mm")) for cell in row] for row in rows])


def from_xlsx(data: bytes) -> tuple[str, np.ndarray]:
    import openpyxl

    book = openpyxl.load_workbook(io.BytesIO(data))
    sheet = book.worksheets[0]
    (unit, *_), *rows = sheet.iter_rows(values_only=True)
    return unit, np.array(rows, float)


def test_ibl(cam: Design) -> None:
    ends, (rows,) = from_ibl(written("ibl", cam, points=361, z_mm=2.5))
    assert ends == "closed"
    np.testing.assert_array_equal(rows[:, :2], points(cam, points=361))
    assert np.all(rows[:, 2] == 2.5)
    ends, (low, high) = from_ibl(written("ibl", cam, points=361, z_mm=-3.0, width_mm=17.25))
    assert ends == "closed"
    np.testing.assert_array_equal(low[:, :2], high[:, :2])
    assert np.all(low[:, 2] == -3.0)
    assert np.all(high[:, 2] == 14.25)


@pytest.mark.parametrize("options", [{"closed": True}, {"overlap_points": 9}], ids=str)
def test_ibl_with_its_end_repeated_is_open(cam: Design, options: dict[str, Any]) -> None:
    ends, (rows,) = from_ibl(written("ibl", cam, points=100, **options))
    assert ends == "open"
    np.testing.assert_array_equal(rows[:, :2], points(cam, points=100, **options))


def test_sldcrv(cam: Design) -> None:
    rows = from_sldcrv(written("sldcrv", cam, points=361, z_mm=-0.5))
    np.testing.assert_array_equal(rows[:, :2], points(cam, points=361, closed=True))
    np.testing.assert_array_equal(rows[0], rows[-1])
    assert np.all(rows[:, 2] == -0.5)
    step = np.hypot(*np.diff(rows[:, :2], axis=0).T)
    assert step.min() >= 0.01


def test_sldcrv_refuses_what_solidworks_does(cam: Design) -> None:
    with pytest.raises(
        InputError, match=r"no points nearer to each other than 0\.01 mm.*cam angle"
    ):
        written("sldcrv", cam, points_per_degree=100.0)
    with pytest.raises(InputError) as caught:
        written("sldcrv", cam, tolerance_um=0.0005)
    assert caught.value.field == "/tolerance_um"


def test_xlsx(cam: Design) -> None:
    data = written("xlsx", cam, points=361, z_mm=4.75)
    unit, rows = from_xlsx(data)
    assert unit == "mm"
    np.testing.assert_array_equal(rows[:, :2], points(cam, points=361, closed=True))
    assert np.all(rows[:, 2] == 4.75)
    with zipfile.ZipFile(io.BytesIO(data)) as packed:
        assert {entry.date_time[0] for entry in packed.infolist()} == {1980}
        assert b"1980-01-01T00:00:00Z" in packed.read("docProps/core.xml")
    assert data == written("xlsx", cam, points=361, z_mm=4.75)


def test_nothing_but_points_in_files_for_cad(cam: Design) -> None:
    for name in ("ibl", "sldcrv", "txt"):
        data = written(name, cam, points=50)
        assert cam.id.encode() not in data
        assert b"amwright" not in data
