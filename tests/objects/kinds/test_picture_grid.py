"""A picture's grid of cells: what lies in a polygon, and what travels between processes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, strategies as st

from talaia.objects.floor_lines import is_inside
from talaia.objects.kinds.picture_grid import area_cells, grid_shape, pack_grid, unpack_grid

PART = st.floats(0, 1)


@given(st.lists(st.tuples(PART, PART), min_size=3, max_size=8), st.integers(1, 9))
@example([(0.0, 0.0), (0.0, 0.0), (0.0, 2.2250738585e-313)], 1)
def test_cells_of_a_polygon_are_those_whose_middle_is_in_it_and_at_least_one(points, rows) -> None:
    shape, polygon = (rows, 7), tuple(points)
    wanted = np.array(
        [
            [is_inside(polygon, ((column + 0.5) / 7, (row + 0.5) / rows)) for column in range(7)]
            for row in range(rows)
        ]
    )
    found = area_cells(shape, polygon)
    if wanted.any():
        np.testing.assert_array_equal(found, wanted)
    else:
        assert found.sum() == 1


@given(st.integers(1, 5000), st.integers(1, 5000))
def test_grid_has_the_pictures_shape_and_no_more_cells_than_are_told(height, width) -> None:
    rows, columns = grid_shape(height, width)
    assert max(rows, columns) == 160
    assert min(rows, columns) == max(1, round(160 * min(height, width) / max(height, width)))


def test_grid_comes_out_of_another_process_as_it_went_in() -> None:
    grid = np.arange(12, dtype=np.uint8).reshape(3, 4)
    np.testing.assert_array_equal(unpack_grid(pack_grid(grid), np.uint8), grid)


@pytest.mark.parametrize("answer", [{"rows": 0}, {"rows": 1000}, {"rows": 4}, {"data": "AAAA"}])
def test_grid_of_another_size_than_it_says_is_none(answer: dict[str, object]) -> None:
    told = {**pack_grid(np.zeros((3, 4), np.uint8)), **answer}
    with pytest.raises(ValueError, match=r"grid of|cannot reshape"):
        unpack_grid(told, np.uint8)
