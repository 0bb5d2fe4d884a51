"""Text and panels over the picture: the one Dear ImGui context, its fonts and its look."""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.resources import as_file, files

import moderngl
from imgui_bundle import imgui, implot

from conf.render.ui.imgui_renderer import ImGuiRenderer

TEXT_PX = 14.0  # height of the text in a picture 480 pixels high
TITLE_PX = 25.0
SCALE_LIMITS = (0.8, 2.5)
PANEL = (0.045, 0.055, 0.075, 0.66)
TEXT = (0.93, 0.95, 0.97, 1.0)
MUTED = (0.66, 0.71, 0.77, 1.0)
ACCENT = (0.40, 0.80, 1.0, 1.0)
PADDING = 9.0  # between a panel's left edge and what it holds, at scale 1
SIZES: dict[str, float | tuple[float, float]] = {  # at scale 1
    "window_rounding": 6.0,
    "window_padding": (PADDING, 7.0),
    "window_min_size": (16.0, 16.0),
    "item_spacing": (6.0, 2.0),
    "cell_padding": (0.0, 1.0),
}


def interface_scale(size: tuple[int, int], pixel_ratio: float) -> float:
    """Return how much larger than in 640 x 480 panels and text are: they grow slower than the picture.

    size : width and height in pixels; pixel_ratio : pixels a point of the display, 2 on a HiDPI one
    """
    points = min(size[0] / 640, size[1] / 480) / pixel_ratio
    low, high = SCALE_LIMITS
    return float(min(max(points**0.5, low), high) * pixel_ratio)


class ImGuiOverlay:
    """Owns the ImGui and ImPlot contexts. There can be one at a time."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._imgui = imgui.create_context()
        self._implot = implot.create_context()
        imgui.set_current_context(self._imgui)  # if one was left, the new one would not be the current
        implot.set_current_context(self._implot)
        io = imgui.get_io()
        io.set_ini_filename("")
        io.set_log_filename("")
        with as_file(files("imgui_bundle") / "assets" / "fonts" / "Roboto") as folder:
            self.regular = io.fonts.add_font_from_file_ttf(str(folder / "Roboto-Regular.ttf"), TEXT_PX)
            self.bold = io.fonts.add_font_from_file_ttf(str(folder / "Roboto-Bold.ttf"), TEXT_PX)
        self._drawing = ImGuiRenderer(ctx)
        self.scale = 0.0
        self.size = (0, 0)

    @contextmanager
    def frame(
        self,
        framebuffer: moderngl.Framebuffer,
        size: tuple[int, int],
        pixel_ratio: float,
        *,
        scale: float | None = None,
    ) -> Iterator[None]:
        """Lay panels out inside, draw them over the framebuffer at the end.

        size : width and height of the framebuffer in pixels
        scale : of text and panels; without it `interface_scale` of the size
        """
        io = imgui.get_io()
        io.display_size = imgui.ImVec2(*size)
        io.delta_time = 1 / 60  # nothing on the picture is animated by ImGui
        self._set_scale(scale or interface_scale(size, pixel_ratio))
        self.size = size
        imgui.new_frame()
        try:
            yield
        except BaseException:
            imgui.end_frame()
            raise
        imgui.render()
        self._drawing.draw(imgui.get_draw_data(), framebuffer, size)

    def show_texture(self, texture: moderngl.Texture) -> imgui.ImTextureRef:
        """Return what ImGui's images need to show a texture; it stays the caller's and must outlive the frame."""
        return self._drawing.show_texture(texture)

    def release(self) -> None:
        """Free the contexts and what they keep on the card."""
        self._drawing.release()
        implot.destroy_context(self._implot)
        imgui.destroy_context(self._imgui)

    def _set_scale(self, scale: float) -> None:
        if scale == self.scale:
            return
        self.scale = scale
        style = imgui.get_style()
        for name, value in SIZES.items():
            setattr(style, name, value * scale if isinstance(value, float) else imgui.ImVec2(*value) * scale)
        style.font_size_base = TEXT_PX
        style.font_scale_main = scale
        style.window_border_size = 0.0
        style.set_color_(imgui.Col_.window_bg, imgui.ImVec4(*PANEL))
        style.set_color_(imgui.Col_.text, imgui.ImVec4(*TEXT))


PANEL_FLAGS = (
    imgui.WindowFlags_.no_decoration
    | imgui.WindowFlags_.no_inputs
    | imgui.WindowFlags_.no_saved_settings
    | imgui.WindowFlags_.no_focus_on_appearing
    | imgui.WindowFlags_.no_nav
)


@contextmanager
def panel(
    name: str, anchor_px: tuple[float, float], pivot: tuple[float, float], size: tuple[float, float]
) -> Iterator[None]:
    """Open a panel: the point `pivot` of it, (0, 0) upper left and (1, 1) lower right, lies at pixel `place`.

    size : width and height of what it holds, in pixels. ImGui could find it out, but hides the panel for a frame then.
    """
    padding = imgui.get_style().window_padding
    imgui.set_next_window_pos(imgui.ImVec2(*anchor_px), imgui.Cond_.always, imgui.ImVec2(*pivot))
    imgui.set_next_window_size(imgui.ImVec2(size[0] + 2 * padding.x, size[1] + 2 * padding.y))
    imgui.begin(name, None, PANEL_FLAGS)
    try:
        yield
    finally:
        imgui.end()


def lines_height(count: int) -> float:
    """Return the height in pixels of so many lines of text."""
    return count * imgui.get_text_line_height_with_spacing() - imgui.get_style().item_spacing.y
