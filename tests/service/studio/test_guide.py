"""The guide: every document is a page, and every link between two documents leads to one."""

from __future__ import annotations

import re
from pathlib import Path
from urllib.parse import urljoin, urlsplit

import pytest
from fastapi import FastAPI
from fastapi.testclient import TestClient

from service import pages

ROOT = Path(__file__).resolve().parents[3]
DOCUMENTS = sorted(
    [*(p.relative_to(ROOT).as_posix() for p in (ROOT / "docs").rglob("*.md")), *pages.AT_THE_TOP]
)


@pytest.fixture(scope="module")
def client() -> TestClient:
    app = FastAPI()
    app.include_router(pages.router)
    return TestClient(app)


def test_the_guide_begins_with_its_index(client: TestClient) -> None:
    page = client.get("/guide")
    assert page.status_code == 200
    assert "by reader" in page.text
    assert "script" not in page.text


def test_every_document_is_in_the_index(client: TestClient) -> None:
    index = client.get("/guide").text
    named = {
        urljoin("/guide/docs/README.md", link) for link in re.findall(r'href="([^"]+)"', index)
    }
    left_out = {f"/guide/{name}" for name in DOCUMENTS} - named
    assert left_out <= {"/guide/README.md", "/guide/docs/README.md"}


def test_links_lead_to_documents_and_headings(client: TestClient) -> None:
    """Over all documents: a link or a picture inside the guide is there, and so is its heading."""
    missing = []
    for name in DOCUMENTS:
        page = client.get(f"/guide/{name}")
        assert page.status_code == 200, name
        for link in re.findall(r'(?:href|src)="([^"]+)"', page.text):
            target = urlsplit(urljoin(f"/guide/{name}", link))
            if target.netloc or not target.path.startswith("/guide/"):
                continue
            there = client.get(target.path)
            heading = f'id="{target.fragment}"'
            if there.status_code != 200 or (target.fragment and heading not in there.text):
                missing.append((name, link))
    assert not missing


@pytest.mark.parametrize(
    "path",
    [
        "../pyproject.toml",
        "docs/../pyproject.toml",
        "service/guide.py",
        "docs",
        "nothing.md",
        "%00/etc/passwd",
        "a" * 5000,
    ],
)
def test_nothing_else_is_served(client: TestClient, path: str) -> None:
    assert client.get(f"/guide/{path.replace('..', '%2e%2e')}").status_code == 404


def test_a_link_to_a_source_file_is_plain_text(client: TestClient) -> None:
    page = client.get("/guide/docs/deployment.md").text
    assert "service/settings.py" in page
    assert 'settings.py"' not in page
