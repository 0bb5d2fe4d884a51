"""The right column: lists, test tone, name, portrait and rate."""

from collections.abc import Iterator

import pytest

from conf.face.head_catalogue import HEADS
from conf.render.window.input_events import KeyStateChanged, TextInput
from conf.settings import load_settings
from conf.start.devices.choices import Choice
from conf.start.gui.device_panel import draw_device_panel, head_choices, rate_choices
from conf.start.gui.picture import CameraPicture
from tests.start.conftest import Stand
from tests.support.imgui_stage import Stage


@pytest.fixture
def picture(stage: Stage) -> Iterator[CameraPicture]:
    with CameraPicture(stage.window.ctx) as picture:
        yield picture


def test_drawing_changes_no_setting(stage: Stage, stand: Stand, picture: CameraPicture) -> None:
    for name, value in (("camera", "rtsp://h/"), ("microphone", "head"), ("speaker", "9"), ("kbps", 3.5)):
        stand.controller.set_setting(name, value)
    before = stand.files.settings.read_text()
    for _ in range(3):
        stage.frame(lambda: draw_device_panel(stand.controller, stage.overlay, picture))
    assert stand.files.settings.read_text() == before


def test_the_test_tone_is_played(
    stage: Stage,
    stand: Stand,
    picture: CameraPicture,
    devices: dict[str, list[str | None]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def draw() -> None:
        draw_device_panel(stand.controller, stage.overlay, picture)

    stage.frame(draw)
    stage.click(*stage.find("Test tone", draw, monkeypatch), draw)
    assert devices["SpeakerTest"] == [None]
    stage.click(*stage.find("Search again###search", draw, monkeypatch), draw)
    assert len(stand.controller._searches) == 2


def test_name_and_portrait_are_kept(
    stage: Stage, stand: Stand, picture: CameraPicture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def draw() -> None:
        draw_device_panel(stand.controller, stage.overlay, picture)

    stage.frame(draw)
    stage.click(*stage.find("##name", draw, monkeypatch), draw)
    stage.feed(TextInput("Anna"), draw)
    stage.frame(draw)
    assert load_settings(stand.files.settings).name is None
    stage.feed(KeyStateChanged("enter", True), draw)
    stage.frame(draw)
    assert load_settings(stand.files.settings).name == "Anna"
    for expected in (True, None):
        stage.click(*stage.find("send photos of my face##portrait", draw, monkeypatch), draw)
        assert load_settings(stand.files.settings).portrait is expected


def test_every_head_has_a_row() -> None:
    rows = head_choices()
    assert rows[0] == Choice("a free one", None) and [row.value for row in rows[1:]] == [head.name for head in HEADS]


def test_a_rate_of_the_settings_has_a_row() -> None:
    rows = rate_choices(3.5)
    assert rows[:3] == [Choice("no limit", None), Choice("2.4 kbit/s", "2.4"), Choice("3.5 kbit/s", "3.5")]
    assert rate_choices(16.0) == rate_choices(None)
