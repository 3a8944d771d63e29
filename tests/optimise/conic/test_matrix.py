"""Rows written into one sparse matrix."""

import numpy as np

from synthesis.optimise.conic.assembly import MatrixBuilder


def test_entries_of_one_place_add_up_and_columns_are_in_order() -> None:
    rng = np.random.default_rng(3)
    writer, dense = MatrixBuilder(7, [], slice(0, 0), None, []), np.zeros((5, 7))
    for first, width in ((4, 3), (0, 2), (3, 2)):
        part = rng.standard_normal((5, width)) * (rng.random((5, width)) < 0.7)
        writer._add_entries(part, first)
        dense[:, first : first + width] += part
    writer._end_rows(np.arange(5.0))
    matrix, rhs = writer.build()
    np.testing.assert_array_equal(matrix.toarray(), dense)
    np.testing.assert_array_equal(rhs, np.arange(5.0))
    assert matrix.has_canonical_format
    for scale in (1.0, -0.37):  # the same places again: where they stand is known by then
        apart = MatrixBuilder(7, [], slice(0, 0), None, [])
        apart._add_entries(scale * dense[:, 2:], 2)
        apart._add_entries(scale * dense[:, :2], 0)
        apart._end_rows(np.arange(5.0))
        np.testing.assert_array_equal(apart.build()[0].toarray(), scale * dense)
