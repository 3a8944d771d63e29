"""Times, memory and drawings of the benchmarks say what was measured."""

from __future__ import annotations

import re
import time
from xml.etree import ElementTree as ET

import pytest

from benchmarks import memory
from benchmarks.axis import Axis, plain, relative, seconds
from benchmarks.diagram import Diagram, Point, Series
from benchmarks.section import Table
from benchmarks.timing import Timing, in_turns, spread, timed

SVG = "{http://www.w3.org/2000/svg}"
TIMES = Timing((0.4, 0.1, 0.3, 0.2, 0.9))


def test_a_timing_tells_median_and_quartiles() -> None:
    assert (TIMES.low, TIMES.median, TIMES.high) == pytest.approx((0.2, 0.3, 0.4))
    assert str(TIMES) == "300 ms (200 to 400)"


@pytest.mark.parametrize(
    ("median", "shown"),
    [(4.321e-4, "0.432 ms"), (0.004321, "4.32 ms"), (0.04321, "43.2 ms"), (4.321, "4.32 s")],
)
def test_times_have_three_digits(median: float, shown: str) -> None:
    assert spread(median, median, median).startswith(f"{shown} (")


def test_a_ratio_is_of_medians_with_quartiles_of_the_rounds() -> None:
    slower = Timing((1.2, 0.2, 0.6, 1.0, 1.8))  # 3, 2, 2, 5 and 2 times
    assert slower.over(TIMES) == "3.3 (2.0 to 3.0)"


def test_calls_take_turns_and_are_told_apart() -> None:
    order = list[str]()
    times = in_turns(
        {"short": lambda: order.append("s"), "long": lambda: (order.append("l"), time.sleep(2e-3))},
        repeats=6,
        warm_up=2,
    )
    assert order[:4] == ["s", "l", "s", "l"]
    rounds = ["".join(sorted(order[k : k + 2])) for k in range(4, 16, 2)]
    assert rounds == ["ls"] * 6
    assert len({"".join(order[k : k + 2]) for k in range(4, 16, 2)}) == 2
    assert times["long"].low >= 2e-3 > times["short"].median
    assert len(timed(lambda: None, repeats=7).seconds) == 7


def test_memory_of_a_process_is_what_it_fills() -> None:
    before, after = memory.grown("import numpy", "kept = numpy.ones(2**20 * 8)")
    assert 62.0 <= after - before <= 80.0


def test_a_table_refuses_rows_of_another_length() -> None:
    assert Table(("a", ">b"), [("1", "2")]).markdown() == "| a | b |\n|---|--:|\n| 1 | 2 |"
    with pytest.raises(ValueError, match="2 columns"):
        Table(("a", ">b"), [("1",)])


@pytest.mark.parametrize(
    ("write", "value", "text"),
    [
        (seconds, 0.02, "20 ms"), (seconds, 5e-6, "5 µs"), (seconds, 1.0, "1 s"),
        (relative, 0.05, "5 %"), (relative, 1e-4, "10⁻⁴"), (relative, 2e-6, "2·10⁻⁶"),
        (relative, 100.0, "100-fold"), (plain, 12000.0, "12\u202f000"),
    ],
)  # fmt: skip
def test_numbers_at_axes(write, value: float, text: str) -> None:
    assert write(value) == text


def drawing(points: list[Point]) -> Diagram:
    axes = Axis("time", seconds), Axis("error", relative, least=1e-6)
    return Diagram("one", "A title & more", "What it shows.", *axes, [Series("first", points)])


def test_points_lie_on_logarithmic_axes() -> None:
    made = drawing([Point(0.001, 1e-1), Point(0.01, 1e-2), Point(0.1, 1e-4), Point(0.1, 0.0)])
    assert made.svg() == made.svg()
    root = ET.fromstring(made.svg())
    marks = root.findall(f"{SVG}circle")[:4]
    x = [float(mark.attrib["cx"]) for mark in marks]
    y = [float(mark.attrib["cy"]) for mark in marks]
    assert x[1] - x[0] == pytest.approx(x[2] - x[1], abs=1e-3)
    assert y[2] - y[1] == pytest.approx(2.0 * (y[1] - y[0]), abs=1e-3)
    assert y[3] - y[2] == pytest.approx(2.0 * (y[1] - y[0]), abs=1e-3)  # at the edge: 1e-6
    numbers = {text.text: text for text in root.findall(f"{SVG}text")}
    assert float(numbers["10 ms"].attrib["x"]) == pytest.approx(x[1], abs=1e-3)
    assert float(numbers["1 %"].attrib["y"]) == pytest.approx(y[1] + 0.9, abs=1e-3)


def test_a_drawing_serves_dark_screens_and_print() -> None:
    text = drawing([Point(0.01, 1e-2, 0.008, 0.02)]).svg().decode()
    assert text.count("prefers-color-scheme:dark") == 2
    assert "@media screen and" in text
    assert len(re.findall(r'class="spread s0"', text)) == 1
    assert "<title>A title &amp; more</title>" in text
