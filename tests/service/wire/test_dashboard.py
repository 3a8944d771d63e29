"""The dashboard asks for metrics that exist, by labels that they have."""

from __future__ import annotations

import json
import re
from pathlib import Path

from service.wire.observe import Metrics

DOCS = Path(__file__).resolve().parents[3] / "docs"
NAME = re.compile(r"\b(?:camwright|process)_[a-z0-9_]+")


def test_queries_and_alarms_name_what_exists() -> None:
    metrics = Metrics()
    help_lines = metrics.page({}, 0, 0, 0, 0).decode().splitlines()
    kinds = dict(line.split()[2:4] for line in help_lines if line.startswith("# TYPE"))
    names = {
        f"{name}{part}"
        for name, kind in kinds.items()
        for part in {"histogram": ("_bucket", "_sum", "_count"), "summary": ("_sum", "_count")}.get(
            kind, ("",)
        )
    }
    labels = {
        label for each in vars(metrics).values() for label in getattr(each, "_labelnames", ())
    }
    labels |= {"le", "instance"}  # of buckets, and of Prometheus itself
    board = json.loads((DOCS / "dashboard.json").read_text(encoding="utf-8"))
    queries = [target["expr"] for panel in board["panels"] for target in panel["targets"]]
    assert len({panel["id"] for panel in board["panels"]}) == len(board["panels"]) > 10
    for query in queries:
        assert query.count("(") == query.count(")"), query
        assert NAME.findall(query), query
        for group in re.findall(r"\bby \(([^)]*)\)", query):
            assert set(group.split(", ")) <= labels, query
    page = (DOCS / "operations.md").read_text(encoding="utf-8")
    assert set(NAME.findall(" ".join(queries))) <= names
    assert set(NAME.findall(page)) <= names
