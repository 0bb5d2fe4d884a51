"""The reference face: the shipped head with its fifty numbered points, to select the point that is placed next."""

import moderngl
import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from conf.animator.picking import nearest_point
from conf.animator.state.point_placement import PointPlacement
from conf.face.control_points import CONTROL_POINTS
from conf.face.deformation.face_model import FaceModel
from conf.face.head_pose import HeadPose
from conf.render.camera import ViewState, clip_matrix
from conf.render.face_renderer import FaceRenderer
from conf.render.ui.imgui_overlay import ACCENT, ImGuiOverlay
from conf.render.ui.rectangle import Rect
from conf.render.ui.theme import AMBER, GREEN

IMAGE_WIDTH = 640  # pixels
HEIGHT_CM = 20.0  # of what the image shows
CENTRE_CM = (0.0, -2.0)  # what the centre of the image shows
POSE = HeadPose(np.zeros(3), -np.array(CENTRE_CM) / HEIGHT_CM, float(np.log(1 / HEIGHT_CM)))

# Pixels at scale 1.
PICK_RADIUS_PX = 11.0  # within which a click selects a point
NUMBER_PX = 10.5  # text height
DOT_RADIUS_PX = 2.6

# Direction from a point to its number, x right, y down: the first entry that the point's name starts with.
LABEL_OFFSETS = {
    "inner_lip_upper": (0, -1), "inner_lip_lower": (0, 1), "inner_lip_corner_l": (-0.7, -1.0),
    "inner_lip_corner_r": (0.7, -1.0), "outer_lip_upper": (0, -1), "cupids": (0, -1), "outer_lip_lower": (0, 1),
    "outer_lip_corner_l": (1, 0.2), "outer_lip_corner_r": (-1, 0.2), "eyelid_upper": (0, -1),
    "eyelid_lower_l": (1, 0.8), "eyelid_lower_r": (-1, 0.8),
    "eye_upper": (0, -1), "eye_lower": (0, 1), "eye_outer_corner_l": (1, 0), "eye_outer_corner_r": (-1, 0),
    "eye_inner_corner_l": (-1, 0.3), "eye_inner_corner_r": (1, 0.3), "brow": (0, -1), "nostril_border_l": (1, 0),
    "nostril_border_r": (-1, 0), "nose_bottom": (0, 1), "pupil_l": (1, 0), "pupil_r": (-1, 0),
    "": (0, 1),
}  # fmt: skip


def reference_clip_matrix(size: tuple[int, int]) -> NDArray[np.float64]:
    """Return the (4, 4) clip matrix of the reference face in an image of (W, H) pixels."""
    return clip_matrix(POSE, ViewState(), aspect=size[0] / size[1])


class ReferenceFace:
    """An image of the head, rendered once, with the points drawn over it."""

    def __init__(self, ctx: moderngl.Context, face: FaceModel, aspect: float) -> None:
        """aspect : height over width"""
        self._points = face.control_points
        size = (IMAGE_WIDTH, round(IMAGE_WIDTH * aspect))
        self._clip = reference_clip_matrix(size)
        self._texture = ctx.texture(size, 4)
        depth = ctx.depth_renderbuffer(size)
        framebuffer = ctx.framebuffer(self._texture, depth)
        renderer = FaceRenderer(ctx, face)
        framebuffer.use()
        framebuffer.clear()
        renderer.draw(face.neutral, POSE, ViewState(), framebuffer)
        self._texture.build_mipmaps()
        self._texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
        for resource in (renderer, framebuffer, depth):
            resource.release()

    def draw(self, overlay: ImGuiOverlay, rect: Rect, placement: PointPlacement) -> int | None:
        """Draw into a rectangle of the open ImGui window. Returns the point that was clicked."""
        corner = imgui.ImVec2(rect.x, rect.y)
        imgui.set_cursor_screen_pos(corner)
        clicked = imgui.invisible_button("reference", imgui.ImVec2(rect.width, rect.height))
        draw_list = imgui.get_window_draw_list()
        end = imgui.ImVec2(rect.x + rect.width, rect.y + rect.height)
        draw_list.add_image(overlay.show_texture(self._texture), corner, end, imgui.ImVec2(0, 1), imgui.ImVec2(1, 0))
        pixels = rect.to_pixels(self._points, self._clip)
        for point in CONTROL_POINTS:
            _draw_point(overlay, draw_list, pixels[point.index], point.index, placement)
        if not imgui.is_item_hovered():
            return None
        mouse = imgui.get_mouse_pos()
        hovered = nearest_point(mouse.x, mouse.y, pixels, radius=PICK_RADIUS_PX * overlay.scale)
        if hovered is not None:
            imgui.set_tooltip(f"{hovered}  {CONTROL_POINTS[hovered].name.replace('_', ' ')}")
        return hovered if clicked else None

    def release(self) -> None:
        """Free the image."""
        self._texture.release()


def _draw_point(
    overlay: ImGuiOverlay,
    draw_list: imgui.ImDrawList,
    pixel: NDArray[np.float64],
    point: int,
    placement: PointPlacement,
) -> None:
    """Draw a dot and its number with a dark outline: selected, placed and missing points differ in colour."""
    scale, selected = overlay.scale, point == placement.selected
    dark = imgui.get_color_u32(imgui.ImVec4(0, 0, 0, 0.75))
    colour = imgui.get_color_u32(imgui.ImVec4(*(ACCENT if selected else GREEN if placement.placed[point] else AMBER)))
    radius = (DOT_RADIUS_PX + 2.0 * selected) * scale
    draw_list.add_circle_filled(imgui.ImVec2(*pixel), radius + 1.2 * scale, dark)
    draw_list.add_circle_filled(imgui.ImVec2(*pixel), radius, colour)
    size = (NUMBER_PX + 3.0 * selected) * scale
    x, y = next(offset for prefix, offset in LABEL_OFFSETS.items() if CONTROL_POINTS[point].name.startswith(prefix))
    text = str(point)
    width = 0.56 * size * len(text)  # a digit of Roboto is 0.56 times as wide as the font is high
    left = pixel[0] + x * (radius + 1 + width / 2) - width / 2
    top = pixel[1] + y * (radius + 0.5 * size) - size / 2
    for dx, dy in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        draw_list.add_text(overlay.bold, size, imgui.ImVec2(left + dx, top + dy), dark, text)
    draw_list.add_text(overlay.bold, size, imgui.ImVec2(left, top), colour, text)
