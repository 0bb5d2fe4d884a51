"""The points on the face while they are placed: dots with their numbers over the picture."""

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from conf.animator.face_view import FaceView
from conf.animator.gui.theme import GREEN
from conf.animator.picking import Rect
from conf.animator.state.point_placement import PointPlacement
from conf.render.ui.imgui_overlay import ACCENT, ImGuiOverlay

DOT_RADIUS_PX = 3.2  # pixels at scale 1
OCCLUDED_ALPHA = 0.22  # opacity of a point on the far side


def draw_control_points(
    overlay: ImGuiOverlay, rect: Rect, placing: PointPlacement, picture: FaceView, clip: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Draw the placed points over the face, faintly those behind it.

    Returns their (n, 2) pixels, nan for those without a place and for those behind, which nobody can take hold of.
    """
    marks = np.full((len(placing.points), 2), np.nan)
    placed = np.flatnonzero(placing.placed)
    if len(placed) == 0:
        return marks
    marks[placed] = rect.to_pixels(placing.points[placed], clip)
    seen = dict(zip(placed.tolist(), picture.visible(placing.points[placed], clip).tolist(), strict=True))
    ink = imgui.get_background_draw_list()
    corner, end = imgui.ImVec2(rect.x, rect.y), imgui.ImVec2(rect.x + rect.width, rect.y + rect.height)
    ink.push_clip_rect(corner, end)
    for point in placed.tolist():
        chosen = point == placing.selected
        cover = 1.0 if seen[point] or chosen else OCCLUDED_ALPHA
        colour = imgui.get_color_u32(imgui.ImVec4(*(ACCENT if chosen else GREEN)[:3], cover))
        dark = imgui.get_color_u32(imgui.ImVec4(0, 0, 0, 0.7 * cover))
        at = imgui.ImVec2(*marks[point])
        radius = (DOT_RADIUS_PX + 1.8 * chosen) * overlay.scale
        ink.add_circle_filled(at, radius + 1.3 * overlay.scale, dark)
        ink.add_circle_filled(at, radius, colour)
        if chosen:
            size = 15.0 * overlay.scale
            beside = imgui.ImVec2(at.x + radius + 4, at.y - size / 2)
            ink.add_text(overlay.bold, size, imgui.ImVec2(beside.x + 1, beside.y + 1), dark, str(point))
            ink.add_text(overlay.bold, size, beside, colour, str(point))
    ink.pop_clip_rect()
    marks[[point for point, front in seen.items() if not front and point != placing.selected]] = np.nan
    return marks
