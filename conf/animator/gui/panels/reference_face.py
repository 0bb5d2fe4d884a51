"""The reference face: the shipped head with its fifty numbered points, to pick the one that is placed next."""

import moderngl
import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from conf.animator.gui.theme import AMBER, GREEN
from conf.animator.picking import Rect, nearest_point
from conf.animator.state.point_placement import PointPlacement
from conf.face.control_points import CONTROL_POINTS
from conf.face.deformation.face_model import FaceModel
from conf.face.head_pose import HeadPose
from conf.render.camera import ViewState, clip_matrix
from conf.render.face_renderer import FaceRenderer
from conf.render.ui.imgui_overlay import ACCENT, ImGuiOverlay

SIDE = 640  # pixels, width of the picture of the reference face
HEIGHT_CM = 20.0  # what its height shows
MIDDLE = (0.0, -2.0)  # cm: what is in the middle of the picture
REACH = 11.0  # pixels at scale 1: a click nearer than this picks a point
NUMBER_PX = 10.5
DOT = 2.6
# Where the number of a point stands beside it, by the first of these that begins its name: x right, y down.
LABEL_OFFSETS = {
    "inner_lip_upper": (0, -1), "inner_lip_lower": (0, 1), "inner_lip_corner_l": (-0.7, -1.0),
    "inner_lip_corner_r": (0.7, -1.0), "outer_lip_upper": (0, -1), "cupids": (0, -1), "outer_lip_lower": (0, 1),
    "outer_lip_corner_l": (1, 0.2), "outer_lip_corner_r": (-1, 0.2), "eyelid_upper": (0, -1),
    "eyelid_lower_l": (1, 0.8), "eyelid_lower_r": (-1, 0.8),
    "eye_upper": (0, -1), "eye_lower": (0, 1), "eye_outer_corner_l": (1, 0), "eye_outer_corner_r": (-1, 0),
    "eye_inner_corner_l": (-1, 0.3), "eye_inner_corner_r": (1, 0.3), "brow": (0, -1), "nostril_border_l": (1, 0),
    "nostril_border_r": (-1, 0), "nose_bottom": (0, 1), "pupil_l": (1, 0), "pupil_r": (-1, 0),
}  # fmt: skip
DEFAULT_LABEL_OFFSET = (0.0, 1.0)


POSE = HeadPose(np.zeros(3), -np.array(MIDDLE) / HEIGHT_CM, float(np.log(1 / HEIGHT_CM)))


def reference_clip_matrix(size: tuple[int, int]) -> NDArray[np.float64]:
    """Return the (4, 4) clip matrix of the reference face in a picture of (W, H) pixels."""
    return clip_matrix(POSE, ViewState(), aspect=size[0] / size[1])


class ReferenceFace:
    """A picture of the head, taken once, and the marks drawn over it."""

    def __init__(self, ctx: moderngl.Context, face: FaceModel, height_over_width: float) -> None:
        self._points = face.control_points
        size = (SIDE, round(SIDE * height_over_width))
        self._texture = ctx.texture(size, 4)
        self._texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        depth = ctx.depth_renderbuffer(size)
        framebuffer = ctx.framebuffer(self._texture, depth)
        self._clip = reference_clip_matrix(size)
        renderer = FaceRenderer(ctx, face)
        framebuffer.use()
        framebuffer.clear()
        renderer.draw(face.neutral, POSE, ViewState(), framebuffer)
        self._texture.build_mipmaps()
        self._texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
        for thing in (renderer, framebuffer, depth):
            thing.release()

    def draw(self, overlay: ImGuiOverlay, rect: Rect, placing: PointPlacement) -> int | None:
        """Draw it into a rectangle of the panel that is open. Returns the point that was clicked."""
        corner = imgui.ImVec2(rect.x, rect.y)
        imgui.set_cursor_screen_pos(corner)
        clicked = imgui.invisible_button("reference", imgui.ImVec2(rect.width, rect.height))
        ink = imgui.get_window_draw_list()
        end = imgui.ImVec2(rect.x + rect.width, rect.y + rect.height)
        ink.add_image(overlay.show_texture(self._texture), corner, end, imgui.ImVec2(0, 1), imgui.ImVec2(1, 0))
        marks = rect.to_pixels(self._points, self._clip)
        mouse = imgui.get_mouse_pos()
        near = nearest_point(mouse.x, mouse.y, marks, reach=REACH * overlay.scale) if imgui.is_item_hovered() else None
        for point in CONTROL_POINTS:
            self._mark(overlay, ink, marks[point.index], point.index, placing)
        if near is not None:
            imgui.set_tooltip(f"{near}  {CONTROL_POINTS[near].name.replace('_', ' ')}")
        return near if clicked else None

    def release(self) -> None:
        """Free the picture."""
        self._texture.release()

    def _mark(
        self,
        overlay: ImGuiOverlay,
        ink: imgui.ImDrawList,
        place: NDArray[np.float64],
        point: int,
        placing: PointPlacement,
    ) -> None:
        scale, chosen = overlay.scale, point == placing.selected
        colour = ACCENT if chosen else GREEN if placing.placed[point] else AMBER
        dark = imgui.get_color_u32(imgui.ImVec4(0, 0, 0, 0.75))
        bright = imgui.get_color_u32(imgui.ImVec4(*colour))
        at = imgui.ImVec2(*place)
        radius = (DOT + 2.0 * chosen) * scale
        ink.add_circle_filled(at, radius + 1.2 * scale, dark)
        ink.add_circle_filled(at, radius, bright)
        size = (NUMBER_PX + 3.0 * chosen) * scale
        name = CONTROL_POINTS[point].name
        x, y = next(
            (beside for prefix, beside in LABEL_OFFSETS.items() if name.startswith(prefix)), DEFAULT_LABEL_OFFSET
        )
        text = str(point)
        width = 0.56 * size * len(text)
        corner = (place[0] + x * (radius + 1 + width / 2) - width / 2, place[1] + y * (radius + 0.5 * size) - size / 2)
        for dx, dy in ((-1, 0), (1, 0), (0, -1), (0, 1)):
            ink.add_text(overlay.bold, size, imgui.ImVec2(corner[0] + dx, corner[1] + dy), dark, text)
        ink.add_text(overlay.bold, size, imgui.ImVec2(*corner), bright, text)
