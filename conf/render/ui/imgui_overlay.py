"""The Dear ImGui context for text and panels over the image: fonts, style, scale."""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.resources import as_file, files

import moderngl
from imgui_bundle import imgui, imgui_ctx, implot

from conf.render.gpu_object import GpuObject
from conf.render.ui.imgui_renderer import ImGuiRenderer
from conf.render.ui.scaling import ScaleRule
from conf.render.window import Window

TEXT_PX = 14.0  # text height in an image 480 pixels high
TITLE_PX = 25.0
SCALE = ScaleRule((640, 480), exponent=0.5, limits=(0.8, 2.5))  # of panels, by the size of the image
PANEL = (0.045, 0.055, 0.075, 0.80)  # over white, MUTED keeps the contrast of 4.5 to 1 that WCAG 2.1 asks for
TEXT = (0.93, 0.95, 0.97, 1.0)
MUTED = (0.66, 0.71, 0.77, 1.0)
ACCENT = (0.40, 0.80, 1.0, 1.0)
PADDING = 9.0  # pixels between a panel's left edge and its content, at scale 1
SIZES: dict[str, float | tuple[float, float]] = {  # pixels at scale 1
    "window_rounding": 6.0,
    "window_padding": (PADDING, 7.0),
    "window_min_size": (16.0, 16.0),
    "item_spacing": (6.0, 2.0),
    "cell_padding": (0.0, 1.0),
}
PANEL_FLAGS = (
    imgui.WindowFlags_.no_decoration
    | imgui.WindowFlags_.no_inputs
    | imgui.WindowFlags_.no_saved_settings
    | imgui.WindowFlags_.no_focus_on_appearing
    | imgui.WindowFlags_.no_nav
)


class ImGuiOverlay(GpuObject):
    """Owner of the ImGui and ImPlot contexts; only one can exist at a time."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._imgui = imgui.create_context()
        self._implot = implot.create_context()
        imgui.set_current_context(self._imgui)  # a context left over would stay the current one
        implot.set_current_context(self._implot)
        io = imgui.get_io()
        io.set_ini_filename("")
        io.set_log_filename("")
        with as_file(files("imgui_bundle") / "assets" / "fonts" / "Roboto") as folder:
            self.regular = io.fonts.add_font_from_file_ttf(str(folder / "Roboto-Regular.ttf"), TEXT_PX)
            self.bold = io.fonts.add_font_from_file_ttf(str(folder / "Roboto-Bold.ttf"), TEXT_PX)
        self._renderer = ImGuiRenderer(ctx)
        self.scale = 0.0
        self.size = (0, 0)

    @contextmanager
    def frame(self, window: Window, *, scale: float | None = None) -> Iterator[None]:
        """Lay out panels inside the `with` block; draw them over the window's framebuffer at its end.

        scale : of text and panels; None takes that of SCALE
        """
        io = imgui.get_io()
        io.display_size = imgui.ImVec2(*window.size)
        io.delta_time = 1 / 60  # seconds; ImGui animates nothing here
        self._set_scale(scale or SCALE.scale(window.size, window.pixel_ratio))
        self.size = window.size
        imgui.new_frame()
        try:
            yield
        except BaseException:
            imgui.end_frame()
            raise
        imgui.render()
        self._renderer.draw(imgui.get_draw_data(), window.framebuffer, window.size)

    def show_texture(self, texture: moderngl.Texture) -> imgui.ImTextureRef:
        """Return a reference for ImGui's images; the caller keeps the texture until the frame is drawn."""
        return self._renderer.show_texture(texture)

    def connect_clipboard(self, window: Window) -> None:
        """Let text fields copy to and paste from the clipboard of a window's desktop."""

        def get(_context: imgui.internal.Context) -> str:
            return window.clipboard

        def set_(_context: imgui.internal.Context, text: str) -> None:
            window.clipboard = text

        platform = imgui.get_platform_io()
        platform.platform_get_clipboard_text_fn, platform.platform_set_clipboard_text_fn = get, set_

    def release(self) -> None:
        self._renderer.release()
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


@contextmanager
def panel(
    name: str, anchor_px: tuple[float, float], pivot: tuple[float, float], size: tuple[float, float]
) -> Iterator[None]:
    """Open a panel whose point `pivot`, (0, 0) upper left to (1, 1) lower right, is at pixel `anchor_px`.

    size : width and height of the content, pixels. ImGui can compute it, but hides the panel for one frame then.
    """
    padding = imgui.get_style().window_padding
    imgui.set_next_window_pos(imgui.ImVec2(*anchor_px), imgui.Cond_.always, imgui.ImVec2(*pivot))
    imgui.set_next_window_size(imgui.ImVec2(size[0] + 2 * padding.x, size[1] + 2 * padding.y))
    with imgui_ctx.begin(name, None, PANEL_FLAGS):
        yield


def lines_height(count: int) -> float:
    """Return the height in pixels of `count` lines of text."""
    return count * imgui.get_text_line_height_with_spacing() - imgui.get_style().item_spacing.y
