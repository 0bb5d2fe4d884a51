import numpy as np
import pytest

from conf.face.deformation.face_model import FaceModel
from conf.render.head_sheet import CELL, COLUMNS, draw_heads


@pytest.mark.slow
def test_heads_are_drawn_in_rows_from_the_upper_left(face: FaceModel) -> None:
    sheet = draw_heads({str(number): face for number in range(COLUMNS + 1)})
    assert sheet.shape == (2 * CELL, COLUMNS * CELL, 3)
    cells = [sheet[CELL // 4 : 3 * CELL // 4, CELL * i : CELL * (i + 1)] for i in range(COLUMNS)]
    assert all(np.array_equal(cell, cells[0]) and np.ptp(cell) > 50 for cell in cells)
    assert np.ptp(sheet[CELL:, :CELL]) > 50 and not sheet[CELL:, CELL:].any()
