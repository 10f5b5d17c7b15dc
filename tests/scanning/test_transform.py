"""The transform from a cloud to the map that was found in it."""

from __future__ import annotations

import numpy as np
import pytest

from rsegen.scanning.scan import Transform


@pytest.mark.parametrize("turns", range(4))
def test_cells_keep_their_places_when_a_field_that_is_no_square_is_turned(turns: int) -> None:
    """As numpy turns them: cell (i, j) of (3, 2) is (n_y - 1 - j, i) of (2, 3) after a quarter turn."""
    width, cells = 0.1, np.arange(6).reshape(3, 2)
    transform = Transform(rotation=np.eye(3), translation=np.zeros(3), cells=(3, 2), width=width).quarter_turned(turns)
    turned = np.rot90(cells.T, -turns).T  # axis 0 is x, axis 1 is y
    assert transform.cells == turned.shape
    for (i, j), number in np.ndenumerate(cells):
        point = np.array([(i + 0.5) * width, (j + 0.5) * width, 0.3])
        x, y, z = transform.rotation @ point + transform.translation
        assert turned[int(x // width), int(y // width)] == number
        assert z == pytest.approx(0.3)
