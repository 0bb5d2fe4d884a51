from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from conf.animator.commands import ApplyPoints, FitPoints, PlacePoints, SetAxes
from conf.animator.face_document import open_face_document
from conf.animator.gui.panels import face as module
from conf.animator.gui.panels.face import draw_face
from conf.animator.state.point_placement import PointPlacement
from tests.animator.conftest import Worked


def test_placing_is_asked_for_and_ok_only_when_all_are_placed(work: Callable[..., Worked]) -> None:
    panel = work(draw_face)
    panel.press("Place points ...")
    assert panel.requests == [PlacePoints()]
    panel.requests.clear()
    panel.desk = replace(panel.desk, placing=PointPlacement())
    panel.press("OK")
    assert panel.requests == []
    panel.desk = replace(panel.desk, placing=PointPlacement(np.ones((50, 3))))
    panel.press("OK")
    assert panel.requests == [ApplyPoints()]


def test_points_can_be_found_and_the_mesh_be_stood_upright_where_there_are_none(
    work: Callable[..., Worked], stranger: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    panel = work(draw_face)
    panel.facts = replace(panel.facts, subject=open_face_document(stranger), can_fit=True)
    panel.press("Find points")
    assert panel.requests == [FitPoints()]
    panel.requests.clear()
    answers = {"crown towards": "z", "nose towards": "x"}
    offered = dict[str, Sequence[str]]()

    def choice(text: str, value: str, names: Sequence[str]) -> str:
        offered[text] = names
        return answers[text]

    monkeypatch.setattr(module, "combo_box", choice)
    panel.press("Place points ...")
    assert SetAxes("z", "x") in panel.requests
    assert "z" in offered["crown towards"] and not {"z", "-z"} & set(offered["nose towards"])
