"""The user interface around the face: two columns of panels, timeline, reference face, notices, help."""

from collections.abc import Callable
from dataclasses import replace

from imgui_bundle import imgui

from conf.animator.controller import Controller
from conf.animator.gui.layout import REFERENCE_ASPECT, Layout
from conf.animator.gui.panels.deformer import draw_deformer, draw_muscles
from conf.animator.gui.panels.export import draw_export
from conf.animator.gui.panels.expressions import draw_expressions
from conf.animator.gui.panels.face import draw_face
from conf.animator.gui.panels.reference_face import ReferenceFace
from conf.animator.gui.panels.timeline import draw_timeline
from conf.animator.gui.panels.view import draw_view
from conf.animator.gui.point_overlay import draw_control_points
from conf.animator.gui.question import draw_question
from conf.animator.keys import help_lines, key_label
from conf.animator.motion_player import REST_POSE
from conf.animator.viewport_controller import ViewportController
from conf.face.loading import load_face
from conf.render.camera import clip_matrix
from conf.render.ui.hud import draw_help, draw_toast
from conf.render.ui.imgui_overlay import MUTED, ImGuiOverlay
from conf.render.ui.theme import column

Panel = Callable[[Controller, float], None]  # draws its tab and calls the controller; the float is the time in seconds

LEFT: dict[str, Panel] = {"Face": draw_face, "Deform": draw_deformer, "Muscles": draw_muscles}
RIGHT: dict[str, Panel] = {"Emotions": draw_expressions, "View": draw_view, "Export": draw_export}
NOTICE_S = 6.0
MARGIN_PX = 12.0  # at scale 1, from the edges of the face to text over it
PANEL_ALPHA = 0.90


class AnimatorGui:
    """Draws everything but the face."""

    def __init__(self, overlay: ImGuiOverlay) -> None:
        self._overlay = overlay
        self._reference: ReferenceFace | None = None
        self.notice, self._notice_until = "", 0.0

    def prepare(self, controller: Controller) -> None:
        """Render the reference face when it is first needed. To be called outside of `overlay.frame`."""
        if controller.state.placement is not None and self._reference is None:
            self._reference = ReferenceFace(controller.ctx, load_face(), REFERENCE_ASPECT)

    def draw(
        self, controller: Controller, viewport: ViewportController, layout: Layout, now: float, fps: float
    ) -> bool:
        """Draw one frame. To be called inside `overlay.frame`. Returns whether the user decided to quit."""
        state = controller.state
        if state.placement is not None:
            clip = clip_matrix(REST_POSE, state.view.camera, aspect=layout.face.width / layout.face.height)
            viewport.point_positions_px = draw_control_points(
                self._overlay, layout.face, state.placement, controller.face.view, clip
            )
            with column("left", layout.left, imgui.WindowFlags_.no_scrollbar):
                draw_face(controller, now)
                self._draw_reference(controller, layout)
        else:
            with column("left", layout.left):
                _draw_tabs("left tabs", LEFT, controller, now)
        with column("right", layout.right):
            _draw_tabs("right tabs", RIGHT, controller, now)
        with column("timeline", layout.timeline):
            draw_timeline(controller, now, self._overlay.scale)
        self._draw_notice(controller, layout, now)
        self._draw_fps(layout, fps)
        centre = (layout.face.x + layout.face.width / 2, layout.face.y + layout.face.height / 2)
        if controller.state.show_help:
            draw_help(self._overlay, help_lines(), centre, opacity=PANEL_ALPHA)
        return draw_question(controller, centre, self._overlay.scale)

    def release(self) -> None:
        """Free all GPU objects."""
        if self._reference is not None:
            self._reference.release()

    def _draw_reference(self, controller: Controller, layout: Layout) -> None:
        placement = controller.state.placement
        if self._reference is None or placement is None:
            return
        clicked = self._reference.draw(self._overlay, layout.reference, placement)
        if clicked is not None:
            controller.state = replace(controller.state, placement=placement.select(clicked))

    def _draw_notice(self, controller: Controller, layout: Layout, now: float) -> None:
        if controller.notice:
            self.notice, controller.notice, self._notice_until = controller.notice, "", now + NOTICE_S
        if now >= self._notice_until:
            return
        face, margin = layout.face, MARGIN_PX * self._overlay.scale
        anchor = (face.x + face.width / 2, face.y + face.height - margin)
        draw_toast(self.notice, anchor, max_width=face.width - 4 * margin, opacity=PANEL_ALPHA)

    def _draw_fps(self, layout: Layout, fps: float) -> None:
        face, margin = layout.face, MARGIN_PX * self._overlay.scale
        text = f"{fps:.0f} frames/s     {key_label('help')} help"
        corner = imgui.ImVec2(face.x + face.width - imgui.calc_text_size(text).x - margin, face.y + margin * 0.6)
        colour = imgui.get_color_u32(imgui.ImVec4(*MUTED[:3], 0.7))
        imgui.get_background_draw_list().add_text(corner, colour, text)


def _draw_tabs(name: str, tabs: dict[str, Panel], controller: Controller, now: float) -> None:
    if imgui.begin_tab_bar(name):
        for title, draw in tabs.items():
            if imgui.begin_tab_item_simple(title):
                draw(controller, now)
                imgui.end_tab_item()
        imgui.end_tab_bar()
