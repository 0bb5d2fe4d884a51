"""Draw the control points over the face while they are placed by hand."""

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from conf.animator.face_view import FaceView
from conf.animator.state.point_placement import PointPlacement
from conf.render.ui.imgui_overlay import ACCENT, ImGuiOverlay
from conf.render.ui.rectangle import Rect
from conf.render.ui.theme import GREEN

DOT_RADIUS_PX = 3.2  # at scale 1
NUMBER_PX = 15.0  # text height at scale 1
OCCLUDED_ALPHA = 0.22  # of points on the far side of the face


def draw_control_points(
    overlay: ImGuiOverlay, rect: Rect, placement: PointPlacement, view: FaceView, clip: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Draw a dot at each placed point, faint if the face hides it, and the number of the selected one.

    Returns (n, 2) window pixels of the points that can be grabbed; nan for points that are missing or hidden.
    """
    pixels = np.full((len(placement.points), 2), np.nan)
    placed = np.flatnonzero(placement.placed)
    if len(placed) == 0:
        return pixels
    positions = placement.points[placed]
    pixels[placed] = rect.to_pixels(positions, clip)
    visible = view.visible(positions, clip) | (placed == placement.selected)
    draw_list = imgui.get_background_draw_list()
    draw_list.push_clip_rect(imgui.ImVec2(rect.x, rect.y), imgui.ImVec2(rect.x + rect.width, rect.y + rect.height))
    for point, in_front in zip(placed.tolist(), visible.tolist(), strict=True):
        selected = point == placement.selected
        alpha = 1.0 if in_front else OCCLUDED_ALPHA
        colour = imgui.get_color_u32(imgui.ImVec4(*(ACCENT if selected else GREEN)[:3], alpha))
        dark = imgui.get_color_u32(imgui.ImVec4(0, 0, 0, 0.7 * alpha))
        centre = imgui.ImVec2(*pixels[point])
        radius = (DOT_RADIUS_PX + 1.8 * selected) * overlay.scale
        draw_list.add_circle_filled(centre, radius + 1.3 * overlay.scale, dark)
        draw_list.add_circle_filled(centre, radius, colour)
        if selected:
            size = NUMBER_PX * overlay.scale
            corner = imgui.ImVec2(centre.x + radius + 4, centre.y - size / 2)
            draw_list.add_text(overlay.bold, size, imgui.ImVec2(corner.x + 1, corner.y + 1), dark, str(point))
            draw_list.add_text(overlay.bold, size, corner, colour, str(point))
    draw_list.pop_clip_rect()
    pixels[placed[~visible]] = np.nan
    return pixels
