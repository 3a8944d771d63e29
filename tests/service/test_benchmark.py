"""The benchmarks that start a service run: their place is beside the service's tests."""

from benchmarks.__main__ import section
from benchmarks.effort import TRIAL


def test_the_benchmark_of_http_runs() -> None:
    times = section("http", TRIAL).parts[0].markdown()
    for told in ("whole request", "core, as reported", "added by HTTP", "from the store"):
        assert told in times


def test_the_benchmark_of_sweeps_runs() -> None:
    table = section("sweeps", TRIAL).parts[0].markdown()
    assert "an item of the sweep" in table
    assert "| 10 |" in table
