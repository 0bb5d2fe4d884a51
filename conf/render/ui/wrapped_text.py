"""Texts that are wrapped at the right edge of their panel."""

from imgui_bundle import imgui

from conf.render.ui.hud import spaced_hyphens
from conf.render.ui.imgui_overlay import MUTED
from conf.render.ui.theme import AMBER


def hint(text: str) -> None:
    """Draw wrapped text in a muted colour."""
    _draw_wrapped(text, MUTED)


def warning(text: str) -> None:
    """Draw wrapped text in a warning colour."""
    _draw_wrapped(text, AMBER)


def _draw_wrapped(text: str, colour: tuple[float, float, float, float]) -> None:
    imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*colour))
    imgui.push_text_wrap_pos(0.0)
    imgui.text_unformatted(spaced_hyphens(text))
    imgui.pop_text_wrap_pos()
    imgui.pop_style_color()
