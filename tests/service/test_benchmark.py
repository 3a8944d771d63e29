"""The benchmarks that start a service run: their place is beside the service's tests."""

from collections.abc import Iterator
from contextlib import nullcontext

import pytest

from benchmarks import http, sweep_size
from benchmarks.__main__ import section
from benchmarks.effort import TRIAL
from benchmarks.section import Table


@pytest.fixture(scope="module", autouse=True)
def one_service() -> Iterator[None]:
    """One for all three: each would start its own."""
    with http.started() as running, pytest.MonkeyPatch.context() as patch:
        patch.setattr(http, "started", lambda: nullcontext(running))
        patch.setattr(sweep_size, "started", lambda: nullcontext(running))
        yield


def test_the_benchmark_of_http_runs() -> None:
    times = section("http", TRIAL).parts[0].markdown()
    for reported in ("whole request", "core, as reported", "added by HTTP", "from the store"):
        assert reported in times


def test_the_benchmark_of_sweeps_runs() -> None:
    table = section("sweeps", TRIAL).parts[0].markdown()
    assert "an item of the sweep" in table
    assert "| 10 |" in table


def test_the_benchmark_of_large_sweeps_runs() -> None:
    """Every process of the service is seen, with sizes that can be."""
    times, memory = section("sweep_size", TRIAL).parts
    assert isinstance(times, Table)
    assert isinstance(memory, Table)
    assert times.rows[0][0] == "10"
    for _, *reported in memory.rows:
        now, peak, worker, most, share = (float(size.removesuffix(" MiB")) for size in reported)
        assert 50.0 < now <= peak
        assert 50.0 < worker <= most
        assert worker < share < 1000.0
