"""Everything over and around the face: the two columns of panels, the time line, the reference face, notices, help."""

from collections.abc import Callable
from dataclasses import replace

from imgui_bundle import imgui

from conf.animator.commands import Request
from conf.animator.controller import Controller
from conf.animator.gui.layout import REFERENCE, Layout
from conf.animator.gui.panels.deformer import draw_deformer
from conf.animator.gui.panels.export import draw_export
from conf.animator.gui.panels.expressions import draw_emotions
from conf.animator.gui.panels.face import draw_face
from conf.animator.gui.panels.muscles import draw_muscles
from conf.animator.gui.panels.reference_face import ReferenceFace
from conf.animator.gui.panels.timeline import draw_timeline
from conf.animator.gui.panels.view import draw_view
from conf.animator.gui.point_overlay import draw_control_points
from conf.animator.gui.theme import column
from conf.animator.motion_player import REST_POSE
from conf.animator.state.editor import EditorState, StatusInfo
from conf.animator.viewport_controller import KEYS, ViewportController
from conf.face.loading import load_face
from conf.render.camera import clip_matrix
from conf.render.ui.hud import draw_help, draw_toast
from conf.render.ui.imgui_overlay import MUTED, ImGuiOverlay

Panel = Callable[[EditorState, StatusInfo], tuple[EditorState, list[Request]]]

LEFT: tuple[tuple[str, Panel], ...] = (("Face", draw_face), ("Deform", draw_deformer), ("Muscles", draw_muscles))
RIGHT: tuple[tuple[str, Panel], ...] = (("Emotions", draw_emotions), ("View", draw_view), ("Export", draw_export))
NOTICE_S = 6.0
MARGIN_PX = 12.0  # pixels at scale 1 from the face's edges to what is written over it
PANEL_ALPHA = 0.90


class AnimatorGui:
    """Draws the panels and asks the director for what they want."""

    def __init__(self, overlay: ImGuiOverlay) -> None:
        self._overlay = overlay
        self._reference: ReferenceFace | None = None
        self._notice, self._notice_until = "", 0.0

    def draw(self, director: Controller, touch: ViewportController, layout: Layout, facts: StatusInfo) -> list[Request]:
        """Draw one frame; the desk is changed. Returns what is asked for. To be called inside `overlay.frame`."""
        desk = director.desk
        requests: list[Request] = []
        if desk.placing is not None:
            clip = clip_matrix(REST_POSE, desk.look.view, aspect=layout.face.width / layout.face.height)
            touch.point_positions_px = draw_control_points(
                self._overlay, layout.face, desk.placing, director.actor.picture, clip
            )
            with column("left", layout.left, imgui.WindowFlags_.no_scrollbar):
                desk, requests = draw_face(desk, facts)
                desk = self._draw_reference(desk, layout)
        else:
            with column("left", layout.left):
                desk, requests = _draw_tabs("left tabs", LEFT, desk, facts)
        with column("right", layout.right):
            desk, asked = _draw_tabs("right tabs", RIGHT, desk, facts)
            requests += asked
        with column("timeline", layout.timeline):
            desk, asked = draw_timeline(desk, facts, self._overlay.scale)
            requests += asked
        director.desk = desk
        self._draw_notice(director, layout, facts.now)
        self._draw_rate(layout, facts)
        if desk.help:
            self._draw_help(layout)
        return requests

    def prepare(self, director: Controller) -> None:
        """Take the reference face's picture if it is about to be shown. To be called outside of `overlay.frame`."""
        if director.desk.placing is not None and self._reference is None:
            self._reference = ReferenceFace(director.ctx, load_face(), REFERENCE)

    def release(self) -> None:
        """Free what is on the card."""
        if self._reference is not None:
            self._reference.release()

    def _draw_reference(self, desk: EditorState, layout: Layout) -> EditorState:
        if self._reference is None or desk.placing is None:
            return desk
        picked = self._reference.draw(self._overlay, layout.reference, desk.placing)
        return desk if picked is None else replace(desk, placing=desk.placing.select(picked))

    def _draw_notice(self, director: Controller, layout: Layout, now: float) -> None:
        if director.notice:
            self._notice, director.notice, self._notice_until = director.notice, "", now + NOTICE_S
        if now >= self._notice_until:
            return
        face, gap = layout.face, MARGIN_PX * self._overlay.scale
        anchor = (face.x + face.width / 2, face.y + face.height - gap)
        draw_toast(self._notice, anchor, max_width=face.width - 4 * gap, opacity=PANEL_ALPHA)

    def _draw_rate(self, layout: Layout, facts: StatusInfo) -> None:
        ink, face = imgui.get_background_draw_list(), layout.face
        text = f"{facts.fps:.0f} pictures a second     H help"
        gap = MARGIN_PX * self._overlay.scale
        width = imgui.calc_text_size(text).x
        place = imgui.ImVec2(face.x + face.width - width - gap, face.y + gap * 0.6)
        ink.add_text(place, imgui.get_color_u32(imgui.ImVec4(*MUTED[:3], 0.7)), text)

    def _draw_help(self, layout: Layout) -> None:
        face = layout.face
        centre = (face.x + face.width / 2, face.y + face.height / 2)
        draw_help(self._overlay, [(key.title(), text) for key, text in KEYS.items()], centre, opacity=PANEL_ALPHA)


def _draw_tabs(
    name: str, tabs: tuple[tuple[str, Panel], ...], desk: EditorState, facts: StatusInfo
) -> tuple[EditorState, list[Request]]:
    requests: list[Request] = []
    if imgui.begin_tab_bar(name):
        for title, draw in tabs:
            if imgui.begin_tab_item_simple(title):
                desk, requests = draw(desk, facts)
                imgui.end_tab_item()
        imgui.end_tab_bar()
    return desk, requests
