from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.receiver.panel_layout import ELLIPSIS, GAP, MARGIN, PanelLayout, PanelSizes, Rect, lay_out, shorten
from conf.receiver.participant_grid import layout_grid

LINE, PANEL = (300.0, 30.0), (176.0, 310.0)  # of the statistics at scale 1, as those that are drawn
HELP, SIGN, TOAST, NAME = (310.0, 320.0), (150.0, 30.0), (260.0, 30.0), (140.0, 30.0)


def rectangles(layout: PanelLayout) -> list[Rect]:
    shown = [layout.stats, layout.recording, layout.help, *layout.messages, *layout.names]
    return [rect for rect in shown if rect is not None]


def cells(count: int, size: tuple[int, int], left: int = 0) -> list[Rect]:
    return [Rect(x, size[1] - y - h, w, h) for x, y, w, h in layout_grid(count, size, left=left)]


@given(
    size=st.sampled_from([(640, 480), (1280, 720), (1920, 1080), (900, 1400)]),
    count=st.integers(1, 9),
    is_open=st.booleans(),
    has_help=st.booleans(),
    has_sign=st.booleans(),
    messages=st.integers(0, 2),
)
def test_no_panel_overlaps_another_or_the_edge(
    size: tuple[int, int], count: int, is_open: bool, has_help: bool, has_sign: bool, messages: int
) -> None:
    stats = PANEL if is_open else LINE
    layout = lay_out(
        size,
        1.0,
        PanelSizes(
            stats,
            is_open,
            SIGN if has_sign else None,
            HELP if has_help else None,
            [TOAST] * messages,
            [(cell, NAME) for cell in cells(count, size, left=184 if is_open else 0)],
        ),
    )
    shown = rectangles(layout)
    assert len(shown) - sum(name is not None for name in layout.names) == 1 + has_sign + has_help + messages
    assert not [pair for pair in combinations(shown, 2) if pair[0].overlaps(pair[1])]
    assert all(0 <= r.left and r.right <= size[0] and 0 <= r.top and r.bottom <= size[1] for r in shown)
    assert has_help or None not in layout.names


def test_the_corners_and_the_order_of_messages() -> None:
    layout = lay_out((1280, 720), 1.0, PanelSizes(LINE, False, SIGN, None, [(100.0, 20.0), TOAST]))
    assert layout.stats[:2] == (MARGIN, MARGIN)
    assert layout.recording == (1280 - MARGIN - SIGN[0], MARGIN, *SIGN)
    upper, lower = layout.messages
    assert lower.bottom == 720 - MARGIN and upper.bottom == lower.top - GAP
    assert upper.left + upper.width / 2 == lower.left + lower.width / 2 == 640


def test_a_name_stands_in_the_lower_left_of_its_cell_and_yields_to_a_message() -> None:
    four = [(cell, NAME) for cell in cells(4, (640, 480))]
    plain, with_message = (
        lay_out((640, 480), 1.0, PanelSizes(LINE, names=four, messages=messages)).names for messages in ([], [TOAST])
    )
    assert plain[2] == (GAP, 480 - GAP - NAME[1], *NAME)
    assert with_message[:3] == plain[:3]
    assert with_message[3] == (640 - GAP - NAME[0], 480 - GAP - NAME[1], *NAME)


def test_names_behind_the_help_are_left_out() -> None:
    nine = [(cell, NAME) for cell in cells(9, (640, 480))]
    names = lay_out((640, 480), 1.0, PanelSizes(LINE, help=HELP, names=nine)).names
    assert names[4] is None and names[0] is not None and names[8] is not None


def test_in_a_narrow_window_the_recording_sign_stands_below_the_line() -> None:
    layout = lay_out((400, 480), 1.0, PanelSizes(LINE, recording=SIGN))
    assert layout.recording is not None and layout.recording.top == layout.stats.bottom + GAP


def test_beside_open_statistics_messages_and_help_move_to_the_right() -> None:
    layout = lay_out((640, 480), 1.0, PanelSizes(PANEL, True, help=HELP, messages=[TOAST]))
    assert layout.help is not None and layout.help.left > layout.stats.right
    assert layout.messages[0].left > layout.stats.right


@pytest.mark.slow
@given(st.text(min_size=0, max_size=30), st.floats(0, 200))
def test_a_shortened_text_fits(text: str, max_width: float) -> None:
    result = shorten(text, max_width, lambda part: 7.0 * len(part))
    assert 7.0 * len(result) <= max_width
    assert result == text if 7.0 * len(text) <= max_width else result in ("", text[: len(result) - 3] + ELLIPSIS)


@pytest.mark.parametrize(("other", "expected"), [(Rect(10, 0, 5, 5), False), (Rect(9, 9, 5, 5), True)])
def test_rectangles_that_touch_do_not_overlap(other: Rect, expected: bool) -> None:
    assert Rect(0, 0, 10, 10).overlaps(other) is expected
