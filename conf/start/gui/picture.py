"""The camera's picture as a texture."""

from __future__ import annotations

import moderngl
from imgui_bundle import imgui

from conf.render.gpu_object import GpuObject
from conf.render.ui.imgui_overlay import MUTED, ImGuiOverlay
from conf.render.ui.theme import AMBER, RAISED
from conf.start.devices.camera_preview import CameraPreview

ASPECT = 4 / 3  # width over height of the frame
PADDING_EMS = 1.0
OPENING = "opening the camera ..."
OFF = "the camera is off"


class CameraPicture(GpuObject):
    """Draws the newest image of a preview."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._texture: moderngl.Texture | None = None
        self._shown: tuple[CameraPreview | None, int] = (None, 0)

    def prepare(self, preview: CameraPreview | None) -> None:
        """Copy the newest image to the graphics card. To be called outside of `overlay.frame`."""
        count, image = (0, None) if preview is None else preview.newest()
        if image is None or (preview, count) == self._shown:
            return
        size = image.shape[1], image.shape[0]
        if self._texture is None or self._texture.size != size:
            self.release()
            self._texture = self._ctx.texture(size, 4)
        self._texture.write(image.tobytes())
        self._shown = (preview, count)

    def draw(self, overlay: ImGuiOverlay, preview: CameraPreview | None, size: tuple[float, float]) -> None:
        """Draw into the next (W, H) pixels of the open panel: the image as large as fits, or why there is none."""
        corner = imgui.get_cursor_screen_pos()
        imgui.dummy(imgui.ImVec2(*size))
        draw_list = imgui.get_window_draw_list()
        end = imgui.ImVec2(corner.x + size[0], corner.y + size[1])
        draw_list.add_rect_filled(corner, end, imgui.get_color_u32(imgui.ImVec4(*RAISED)))
        error = preview.error if preview is not None else ""
        if self._texture is not None and self._shown[0] is preview and preview is not None and not error:
            scale = min(size[0] / self._texture.width, size[1] / self._texture.height)
            width, height = scale * self._texture.width, scale * self._texture.height
            low = imgui.ImVec2(corner.x + (size[0] - width) / 2, corner.y + (size[1] - height) / 2)
            high = imgui.ImVec2(low.x + width, low.y + height)
            draw_list.add_image(overlay.show_texture(self._texture), low, high)
            return
        text = error or (OPENING if preview is not None else OFF)
        _draw_in_middle(text, AMBER if error else MUTED, corner, size)

    def release(self) -> None:
        """Free the texture."""
        if self._texture is not None:
            self._texture.release()
            self._texture = None


def _draw_in_middle(
    text: str, colour: tuple[float, float, float, float], corner: imgui.ImVec2, size: tuple[float, float]
) -> None:
    wrap = size[0] - 2 * PADDING_EMS * imgui.get_font_size()
    measured = imgui.calc_text_size(text, wrap_width=wrap)
    at = imgui.ImVec2(corner.x + (size[0] - measured.x) / 2, corner.y + (size[1] - measured.y) / 2)
    imgui.get_window_draw_list().add_text(
        imgui.get_font(), imgui.get_font_size(), at, imgui.get_color_u32(imgui.ImVec4(*colour)), text, wrap_width=wrap
    )
