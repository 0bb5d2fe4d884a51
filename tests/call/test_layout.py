from itertools import combinations
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.call.layout import CallLayout, CallSizes, lay_out_call
from conf.receiver.panel_layout import Rect

USUAL = CallSizes(
    status=(420.0, 30.0),
    toolbar=(560.0, 36.0),
    recording=(120.0, 30.0),
    self_aspect=4 / 3,
    name=(180.0, 30.0),
    messages=((300.0, 30.0), (400.0, 50.0)),
)


def rects(layout: CallLayout) -> list[Rect]:
    """Return all that is placed."""
    single = (layout.status, layout.toolbar, layout.stats, layout.notice, layout.recording, layout.help, layout.own)
    return [rect for rect in (*single, layout.name, *layout.messages) if rect is not None]


def sizes() -> st.SearchStrategy[Any]:
    """Return sizes of panels, as large as they may become."""
    return st.tuples(st.floats(10, 700), st.floats(10, 400))


@given(
    st.tuples(st.integers(64, 2600), st.integers(64, 1600)),
    st.floats(0.8, 2.5),
    st.builds(
        CallSizes,
        status=sizes(),
        toolbar=st.none() | sizes(),
        stats=st.none() | sizes(),
        notice=st.none() | sizes(),
        recording=st.none() | sizes(),
        help=st.none() | sizes(),
        self_aspect=st.none() | st.floats(0.4, 2.5),
        name=st.none() | sizes(),
        messages=st.lists(sizes(), max_size=3),
    ),
)
def test_nothing_overlaps_and_nothing_is_outside(size: tuple[int, int], scale: float, content: CallSizes) -> None:
    layout = lay_out_call(size, scale, content)
    found = rects(layout)
    assert not [pair for pair in combinations(found, 2) if pair[0].overlaps(pair[1])]
    assert all(r.left >= 0 and r.top >= 0 and r.right <= size[0] and r.bottom <= size[1] for r in found)
    assert len(layout.messages) == len(content.messages)


@pytest.mark.parametrize("size", [(1280, 720), (1920, 1080), (800, 600)])
def test_in_a_usual_window_everything_has_room(size: tuple[int, int]) -> None:
    layout = lay_out_call(size, 1.0, USUAL)
    assert len(rects(layout)) == 7 and layout.notice is None and layout.help is None
    assert layout.toolbar and layout.own and layout.name and layout.status
    assert layout.toolbar.left + layout.toolbar.width / 2 == size[0] / 2
    assert layout.own.right > size[0] - 20 and layout.name.left < 20 and layout.status.top < 20
    assert layout.own.width / layout.own.height == pytest.approx(4 / 3)
    upper, lower = layout.messages
    assert upper and lower and upper.bottom < lower.top and lower.bottom < layout.toolbar.top


def test_one_s_own_image_moves_up_where_the_buttons_are_wide() -> None:
    layout = lay_out_call((640, 480), 1.0, USUAL)
    assert layout.own and layout.toolbar and layout.own.bottom < layout.toolbar.top


def test_the_code_stands_in_the_middle_and_help_beside_open_figures() -> None:
    layout = lay_out_call((1280, 720), 1.0, CallSizes((200.0, 30.0), notice=(400.0, 150.0)))
    assert layout.notice == Rect(440.0, 285.0, 400.0, 150.0)
    layout = lay_out_call((900, 720), 1.0, CallSizes((200.0, 30.0), stats=(300.0, 400.0), help=(400.0, 400.0)))
    assert layout.stats and layout.help and layout.help.left > layout.stats.right
