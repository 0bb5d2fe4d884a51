"""One's own image in the corner of the window: the camera's, or what the other sees."""

import moderngl
import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from conf.call.self_view import SelfView
from conf.receiver.panel_layout import Rect
from conf.render.gpu_object import GpuObject
from conf.render.ui.imgui_overlay import MUTED, TEXT, ImGuiOverlay, panel

ASPECT = 4 / 3  # without an image
BORDER = (0.93, 0.95, 0.97, 0.35)
EMPTY = (0.075, 0.088, 0.110, 0.96)
CAPTION = (0.045, 0.055, 0.075, 0.66)
ROUNDING = 6.0  # pixels at scale 1


class SelfPicture(GpuObject):
    """Draws one's own image with a caption."""

    def __init__(self, ctx: moderngl.Context, view: SelfView) -> None:
        self._ctx = ctx
        self._view = view
        self._texture: moderngl.Texture | None = None
        self._uploaded: NDArray[np.uint8] | None = None
        self._aspect = ASPECT

    @property
    def aspect(self) -> float:
        """Width over height, of the last image while there is none."""
        if (image := self._view.image) is not None:
            self._aspect = image.shape[1] / image.shape[0]
        return self._aspect

    def draw(self, overlay: ImGuiOverlay, rect: Rect, caption: str, *, is_drawn: bool) -> None:
        """Draw the image into a rectangle. Call it inside `overlay.frame`.

        is_drawn : the rectangle has been drawn into already; only border and caption are added
        """
        scale = overlay.scale
        low, high = imgui.ImVec2(rect.left, rect.top), imgui.ImVec2(rect.right, rect.bottom)
        padding = imgui.get_style().window_padding
        imgui.set_next_window_bg_alpha(0.0)
        size = rect.width - 2 * padding.x, rect.height - 2 * padding.y
        with panel("self view", (rect.left, rect.top), (0.0, 0.0), size):
            draw = imgui.get_window_draw_list()
            image = None if is_drawn else self._view.image
            if image is not None:
                texture = overlay.show_texture(self._upload(image))
                draw.add_image_rounded(
                    texture, low, high, imgui.ImVec2(0, 0), imgui.ImVec2(1, 1), 0xFFFFFFFF, ROUNDING * scale
                )
            elif not is_drawn:
                draw.add_rect_filled(low, high, _u32(EMPTY), ROUNDING * scale)
            inner = imgui.ImVec2(rect.left + 1, rect.top + 1), imgui.ImVec2(rect.right - 1, rect.bottom - 1)
            draw.add_rect(*inner, _u32(BORDER), 0.0 if is_drawn else ROUNDING * scale)
            self._draw_caption(draw, rect, caption, scale)

    def release(self) -> None:
        """Free the texture."""
        if self._texture:
            self._texture.release()

    @staticmethod
    def _draw_caption(draw: imgui.ImDrawList, rect: Rect, caption: str, scale: float) -> None:
        text = imgui.calc_text_size(caption)
        x, height = rect.left + 8 * scale, text.y + 6 * scale
        low = imgui.ImVec2(rect.left + 1, rect.bottom - height - 1)
        width = min(text.x + 16 * scale, rect.width - 2)
        draw.add_rect_filled(low, imgui.ImVec2(low.x + width, rect.bottom - 1), _u32(CAPTION), ROUNDING * scale)
        draw.push_clip_rect(low, imgui.ImVec2(low.x + width, rect.bottom), True)
        draw.add_text(imgui.ImVec2(x, low.y + 3 * scale), _u32(TEXT if caption else MUTED), caption)
        draw.pop_clip_rect()

    def _upload(self, image: NDArray[np.uint8]) -> moderngl.Texture:
        """Return the texture with the newest image, (H, W, 4) uint8 RGBA."""
        size = image.shape[1], image.shape[0]
        if self._texture is None or self._texture.size != size:
            if self._texture:
                self._texture.release()
            self._texture, self._uploaded = self._ctx.texture(size, 4), None
            self._texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        if self._uploaded is not image:
            self._texture.write(image.tobytes())
            self._uploaded = image
        return self._texture


def _u32(colour: tuple[float, float, float, float]) -> int:
    return int(imgui.get_color_u32(imgui.ImVec4(*colour)))
