from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from conf.animator.file_export import SUFFIXES, check_output
from conf.animator.gui.panels import export as module
from conf.animator.gui.panels.export import FORMATS, draw_export
from conf.animator.state.editor import RECORDING
from conf.face.formats.dpc import MotionClip, read_dpc
from tests.animator.conftest import NOW, PanelDriver

pytestmark = pytest.mark.slow


def set_output(panel: PanelDriver, path: Path, **fields: str) -> None:
    state = panel.state
    panel.controller.state = replace(state, fields=replace(state.fields, output=str(path), **fields))


def test_every_format_can_be_exported() -> None:
    assert set(SUFFIXES) - set(FORMATS) == {".jpeg"} and set(FORMATS) < set(SUFFIXES)


def test_size_and_frame_rate_are_asked_for_where_the_format_has_them(
    open_panel: Callable[..., PanelDriver], tmp_path: Path
) -> None:
    panel = open_panel(draw_export)
    options = {"##size, px", "##frames/s"}
    for suffix, expected in ((".png", {"##size, px"}), (".obj", set()), (".mp4", options), (".csv", {"##frames/s"})):
        set_output(panel, tmp_path / f"a{suffix}")
        assert panel.labels() & options == expected, suffix


def test_choosing_a_format_changes_the_suffix_only(
    open_panel: Callable[..., PanelDriver], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    panel = open_panel(draw_export)
    set_output(panel, tmp_path / "a.b.jpg")
    sources: list[str] = []

    def choose(label: str, value: str, names: list[str]) -> str:
        sources[:] = names if label == "source" else sources
        return "motion, DPC" if label == "format" else value

    monkeypatch.setattr(module, "combo_box", choose)
    panel.draw()
    assert panel.state.fields.output == str(tmp_path / "a.b.dpc")
    check_output(Path(panel.state.fields.output))
    assert "joy" in sources and RECORDING not in sources
    panel.controller.play_clip("a", MotionClip(10.0, "fapu", np.zeros((3, 50, 3), np.float32)), NOW)
    panel.draw()
    assert RECORDING in sources


def test_the_button_exports_the_current_view(open_panel: Callable[..., PanelDriver], tmp_path: Path) -> None:
    panel = open_panel(draw_export)
    set_output(panel, tmp_path / "a.png", size="64x48")
    panel.press("Export##button")
    assert panel.controller.notice == f"saved {tmp_path / 'a.png'}"
    assert np.asarray(cv2.imread(str(tmp_path / "a.png"))).shape == (48, 64, 3)


def test_an_export_in_progress_can_be_cancelled_or_finished(
    open_panel: Callable[..., PanelDriver], tmp_path: Path
) -> None:
    panel = open_panel(draw_export)
    set_output(panel, tmp_path / "a.dpc", source="joy", fps="15")
    panel.press("Export##button")
    assert panel.controller.export_progress == 0.0
    assert "Cancel export" in panel.labels() and "Export##button" not in panel.labels()
    panel.press("Cancel export")
    assert panel.controller.export_progress is None and "cancelled" in panel.controller.notice
    panel.press("Export##button")
    while panel.controller.export_progress is not None:
        panel.controller.update(NOW)
        panel.draw()
    assert read_dpc(tmp_path / "a.dpc").fps == 15.0 and "saved" in panel.controller.notice


def test_an_invalid_size_is_reported(open_panel: Callable[..., PanelDriver], tmp_path: Path) -> None:
    panel = open_panel(draw_export)
    set_output(panel, tmp_path / "a.png", size="wide")
    panel.press("Export##button")
    assert "size must be WIDTHxHEIGHT" in panel.controller.notice and not (tmp_path / "a.png").exists()
