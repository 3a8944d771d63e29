"""Texts of numbers: those of ``repr``, for every double."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from synthesis.exporters.tables import number_texts


def texts(values: np.ndarray) -> list[str]:
    return [text.decode("ascii") for text in number_texts(values)]


@given(st.lists(st.floats(allow_nan=False, min_value=-1.7e308), min_size=1, max_size=40))
@example([0.3, 0.1 + 0.2, 2 / 3, 1e22, 1e23, 9007199254740993.0, 5e-324, 2.0**-1074, 0.0001])
@example([671820528563070.75, 833851329190896.75, 608707256456481.75])  # half-way cases
def test_every_double(values: list[float]) -> None:
    assert texts(np.array(values)) == [repr(value + 0.0) for value in values]


@pytest.mark.parametrize("decimals", [None, 0, 1, 2, 5, 9])
def test_columns_of_usual_size(decimals: int | None) -> None:
    rng = np.random.default_rng(20)
    values = rng.standard_normal(20000) * 10.0 ** rng.uniform(-5.0, 16.0, 20000)
    if decimals is not None:
        values = np.round(values, decimals) + 0.0
    assert texts(values) == [repr(value) for value in values.tolist()]


def test_beside_powers_of_two_and_ten() -> None:
    powers = np.concatenate([2.0 ** np.arange(-16, 55), 10.0 ** np.arange(-6, 18)])
    values = np.concatenate(
        [powers, np.nextafter(powers, 0.0), np.nextafter(powers, np.inf), -powers]
    )
    assert texts(values) == [repr(value) for value in values.tolist()]


def test_whole_numbers_have_no_point() -> None:
    assert texts(np.array([-1, 0, 1, 123456789012345678])) == ["-1", "0", "1", "123456789012345678"]


def test_the_word_for_infinity() -> None:
    assert number_texts(np.array([np.inf, 1.5]), infinite="null") == [b"null", b"1.5"]
