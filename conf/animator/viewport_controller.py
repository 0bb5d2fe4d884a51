"""Mouse and keys over the face: orbit, placing points, key commands."""

from dataclasses import replace
from typing import Literal, get_args

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from conf.animator.controller import Controller
from conf.animator.gui.layout import Layout
from conf.animator.keys import KEYS, key_label, key_of
from conf.animator.motion_player import REST_POSE
from conf.animator.picking import nearest_point
from conf.animator.state.point_placement import PointPlacement
from conf.render.camera import clip_matrix
from conf.render.ui.imgui_input import is_typing
from conf.render.window import input_events
from conf.render.window.input_events import Event, KeyStateChanged

PICK_RADIUS_PX = 9.0  # pixels at scale 1 within which a press grabs a point
CLICK_TOLERANCE_PX = 5.0  # pixels at scale 1: a press that moves no farther is a click

WindowCommand = Literal["quit", "screenshot", "record", "full screen"]
WINDOW_COMMANDS: dict[str, WindowCommand] = {name: name for name in get_args(WindowCommand)}
NO_POINTS = "this face has no control points yet: Find points or Place points in the panel Face sets them"


class ViewportController:
    """Translates window events over the face into calls of the controller.

    point_positions_px : (n, 2) window pixels of the points that can be grabbed, nan for others; set by the GUI
    """

    def __init__(self, controller: Controller) -> None:
        self._controller = controller
        self._pressed_at: tuple[float, float] | None = None
        self._grabbed: int | None = None
        self._moved = False
        self._ctrl = False
        self._mouse = (0.0, 0.0)
        self.point_positions_px: NDArray[np.float64] = np.full((50, 2), np.nan)

    def process_events(
        self, events: list[input_events.Event], layout: Layout, scale: float, now: float
    ) -> set[WindowCommand]:
        """Handle the events of one frame. Returns what is left for the window."""
        commands: set[WindowCommand] = set()
        for event in events:
            key = None if is_typing() else key_of(event, ctrl=self._ctrl)
            if key is not None:
                commands |= self._process_key(key, now)
            match event:
                case KeyStateChanged(key="left_ctrl" | "right_ctrl", pressed=pressed):
                    self._ctrl = pressed
                case input_events.MouseMoved(x=x, y=y):
                    self._mouse = (x, y)
                    self._drag_point(layout, scale)
                case input_events.MouseButton(button=0, pressed=True, x=x, y=y):
                    self._press(x, y, layout, scale)
                case input_events.MouseButton(button=0, pressed=False):
                    self._release(layout)
                case input_events.Dragged() if self._grabbed is None and (self._pressed_at or event.mode == "pan"):
                    self._move_camera(event)
                case input_events.Scrolled() if layout.face.contains(*self._mouse) and not _popup_open():
                    self._move_camera(event)
                case _:
                    pass
        return commands

    def _move_camera(self, event: Event) -> None:
        state = self._controller.state
        camera = input_events.apply_camera_event(state.view.camera, event)
        self._controller.state = replace(state, view=replace(state.view, camera=camera))

    def _process_key(self, key: str, now: float) -> set[WindowCommand]:
        """Carry out the action of a key. Returns the window's command, if it is one."""
        action = KEYS[key][0]
        controller = self._controller
        if controller.state.question is not None:
            return self._answer(action)
        if action == "back":
            if _popup_open() or self._step_back():
                return set()
            action = "quit"
        if action in WINDOW_COMMANDS:
            return {WINDOW_COMMANDS[action]}
        match action:
            case "play":
                self._play(now)
            case "step":
                self._step(1 if key == "right_arrow" else -1, now)
            case "undo":
                self._undo()
            case _:
                self._change_view(action)
        return set()

    def _answer(self, action: str) -> set[WindowCommand]:
        """Process a key while a question is open: quitting again means it, Escape closes the question."""
        if action == "quit":
            return {"quit"}
        if action == "back":
            self._controller.state = replace(self._controller.state, question=None)
        return set()

    def _step_back(self) -> bool:
        """Close the help or stop placing points. Returns whether one of them was open."""
        controller = self._controller
        if controller.state.show_help:
            controller.state = replace(controller.state, show_help=False)
        elif controller.state.placement is not None:
            controller.cancel_placement()
        else:
            return False
        return True

    def _change_view(self, action: str) -> None:
        """Switch style, points, eye contact or help, or reset the camera; say so if that shows nothing."""
        controller = self._controller
        state, document = controller.state, controller.face.document
        view = state.view
        match action:
            case "wireframe" | "regions":
                view = replace(view, style="rendered" if view.style == action else action)
                if view.style == "regions" and document.points is None:
                    controller.notice = NO_POINTS
            case "points" if document.points is None:
                controller.notice = NO_POINTS
            case "points":
                view = replace(view, camera=view.camera.toggled("points"))
                if view.camera.points and view.style == "regions":
                    controller.notice = f"regions hide the control points: {key_label('regions')} shows the face again"
            case "eye contact":
                view = replace(view, eye_contact=not view.eye_contact)
                if view.eye_contact and not (document.rig and document.rig.eyes):
                    controller.notice = "this face has no eyeballs that could turn to you"
            case "reset":
                view = replace(view, camera=view.camera.reset())
            case "help":
                state = replace(state, show_help=not state.show_help)
        controller.state = replace(state, view=view)

    def _undo(self) -> None:
        controller = self._controller
        placement = controller.state.placement
        if placement is None:
            controller.notice = f"{key_label('undo')} works while control points are placed"
        else:
            self._set_placement(placement.undo())

    def _play(self, now: float) -> None:
        """Pause or resume the recording; without one, repeat the newest running expression."""
        controller = self._controller
        if controller.player is not None:
            controller.player.toggle(now)
        elif controller.state.expression.running:
            controller.play_expression(controller.state.expression.running[-1].name, now)
        else:
            controller.notice = "nothing to play: open a recording below, or press an emotion"

    def _step(self, frames: int, now: float) -> None:
        player = self._controller.player
        if player is None:
            self._controller.notice = "no recording to step through: open a DPC file below"
        else:
            player.step(frames, player.clip.fps, now)

    def _press(self, x: float, y: float, layout: Layout, scale: float) -> None:
        if not layout.face.contains(x, y) or _popup_open():
            return
        self._pressed_at, self._moved, self._mouse = (x, y), False, (x, y)
        if self._controller.state.placement is not None:
            self._grabbed = nearest_point(x, y, self.point_positions_px, radius=PICK_RADIUS_PX * scale)

    def _drag_point(self, layout: Layout, scale: float) -> None:
        if self._pressed_at is None:
            return
        distance = np.hypot(self._mouse[0] - self._pressed_at[0], self._mouse[1] - self._pressed_at[1])
        moved_before = self._moved
        self._moved = moved_before or bool(distance > CLICK_TOLERANCE_PX * scale)
        placement = self._controller.state.placement
        if self._grabbed is None or placement is None or not self._moved:
            return
        if not moved_before:
            placement = placement.push_undo().select(self._grabbed)
        self._set_point(placement, self._grabbed, layout)

    def _release(self, layout: Layout) -> None:
        """End a drag. A click places the selected point, or selects the one under it if the selected is placed."""
        placement = self._controller.state.placement
        if placement is not None and self._pressed_at and not self._moved:
            if self._grabbed is not None and placement.placed[placement.selected]:
                self._set_placement(placement.select(self._grabbed))
            else:
                placed = self._set_point(placement.push_undo(), placement.selected, layout)
                if placed:
                    self._set_placement(placed.advance())
        self._pressed_at, self._grabbed = None, None

    def _set_point(self, placement: PointPlacement, point: int, layout: Layout) -> PointPlacement | None:
        """Set a point to the surface under the mouse. Returns None beside the face."""
        controller = self._controller
        clip = clip_matrix(REST_POSE, controller.state.view.camera, aspect=layout.face.width / layout.face.height)
        position = controller.face.picker.pick(layout.face.to_ndc(*self._mouse), clip)
        if position is None:
            return None
        mirrored = controller.mirrored(placement, position) if placement.mirror else None
        placement = placement.set_point(point, position, mirrored)
        self._set_placement(placement)
        return placement

    def _set_placement(self, placement: PointPlacement) -> None:
        self._controller.state = replace(self._controller.state, placement=placement)


def _popup_open() -> bool:
    """Tell whether a list is open: a press closes it and is not meant for the face."""
    return bool(imgui.is_popup_open("", imgui.PopupFlags_.any_popup))
