from types import SimpleNamespace

import pytest

from conf.receiver.notifications import Notifications
from conf.receiver.panel_layout import Rect
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.offscreen import OffscreenWindow

pytestmark = pytest.mark.slow
SHOWN = Notifications(["saved conf-001.jpg", "muted"], [("R", 3.0)], [("R", "record a clip")], 200.0)


def test_what_is_not_shown_has_no_size(gl: None) -> None:
    with OffscreenWindow(640, 480) as window, ImGuiOverlay(window.ctx) as overlay:
        window.begin()
        with overlay.frame(window):
            assert Notifications([], [], [], 200.0).sizes(overlay) == (None, None, [])
            sizes = SHOWN.sizes(overlay)
            assert sizes.recording and sizes.help and len(sizes.messages) == 2
            narrow = Notifications(["a message of many words that has to be wrapped"], [], [], 100.0)
            wide = Notifications(narrow.messages, [], [], 600.0)
            assert narrow.sizes(overlay).messages[0][1] > wide.sizes(overlay).messages[0][1]


def test_all_is_drawn_where_there_is_room(gl: None) -> None:
    images = []
    places = {"recording": Rect(500, 10, 100, 30), "help": Rect(200, 150, 200, 60), "message": Rect(250, 400, 140, 30)}
    with OffscreenWindow(640, 480) as window, ImGuiOverlay(window.ctx) as overlay:
        for chosen in [None, *places]:
            rects = {name: rect if name == chosen else None for name, rect in places.items()}
            layout = SimpleNamespace(
                recording=rects["recording"], help=rects["help"], messages=[rects["message"], None]
            )
            window.begin()
            with overlay.frame(window):
                SHOWN.draw(overlay, layout)
            images.append(window.read().astype(int))
    for image, place in zip(images[1:], places.values(), strict=True):
        rows, columns = (image != images[0]).any(axis=2).nonzero()
        assert abs(columns.mean() - (place.left + place.width / 2)) < 60
        assert abs(rows.mean() - (place.top + place.height / 2)) < 40
