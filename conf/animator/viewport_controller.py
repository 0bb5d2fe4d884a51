"""What mouse and keys do to the face itself: turn it, place points on it, switch its looks."""

from dataclasses import dataclass, replace

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from conf.animator import commands as ask
from conf.animator.controller import Controller
from conf.animator.gui.layout import Layout
from conf.animator.motion_player import REST_POSE
from conf.animator.picking import nearest_point
from conf.animator.state.point_placement import PointPlacement
from conf.render.camera import clip_matrix
from conf.render.ui.imgui_input import is_typing
from conf.render.window.input_events import (
    Dragged,
    Event,
    KeyPressed,
    KeyStateChanged,
    MouseButton,
    MouseMoved,
    Scrolled,
    apply_camera_event,
)

PICK_RADIUS_PX = 9.0  # pixels at scale 1: a press nearer than this takes hold of a point
CLICK_TOLERANCE_PX = 5.0  # pixels at scale 1: a press that moves less is a click

KEYS = {
    "space": "play and pause, or start the emotion again",
    "left, right": "one frame back, one on",
    "w": "wireframe",
    "g": "regions of influence",
    "p": "control points",
    "e": "eye contact",
    "s": "save a picture of what is shown",
    "r": "record what you see as AVI, stop recording",
    "f": "full screen",
    "home": "look straight again",
    "ctrl + z": "undo, while placing points",
    "h": "this help",
    "escape, q": "quit",
}


@dataclass(frozen=True)
class WindowCommands:
    """What is left for the loop: things only it can do."""

    quit: bool = False
    picture: bool = False
    record: bool = False
    full_screen: bool = False


class ViewportController:
    """Follows the mouse over the face."""

    def __init__(self, director: Controller) -> None:
        self._director = director
        self._pressed_at: tuple[float, float] | None = None
        self._grabbed: int | None = None
        self._moved = False
        self._ctrl = False
        self._mouse = (0.0, 0.0)
        self.point_positions_px: NDArray[np.float64] = np.full((50, 2), np.nan)

    def process_events(self, events: list[Event], layout: Layout, scale: float, now: float) -> WindowCommands:
        """Do what the events ask of the face."""
        wishes = WindowCommands()
        for event in events:
            match event:
                case KeyStateChanged(key="left_ctrl" | "right_ctrl", pressed=pressed):
                    self._ctrl = pressed
                case KeyStateChanged(key=key, pressed=True) if not is_typing():
                    self._step(key, now)
                case KeyPressed(key=key) if not is_typing():
                    wishes = self._key(key, wishes, now)
                case MouseMoved(x=x, y=y):
                    self._mouse = (x, y)
                    self._drag_point(layout, scale)
                case MouseButton(button=0, pressed=True, x=x, y=y):
                    self._press(x, y, layout, scale)
                case MouseButton(button=0, pressed=False):
                    self._release(layout)
                case Dragged() if self._grabbed is None and (self._pressed_at or event.mode == "pan"):
                    self._view(event)
                case Scrolled() if layout.face.contains(*self._mouse) and not _popup_open():
                    self._view(event)
                case _:
                    pass
        return wishes

    def _view(self, event: Event) -> None:
        director = self._director
        look = director.desk.look
        director.desk = replace(director.desk, look=replace(look, view=apply_camera_event(look.view, event)))

    def _step(self, key: str, now: float) -> None:
        frames = {"left_arrow": -1, "right_arrow": 1}.get(key)
        if frames:
            self._director.handle(ask.StepFrames(frames), now)

    def _key(self, key: str, wishes: WindowCommands, now: float) -> WindowCommands:
        director = self._director
        desk, look = director.desk, director.desk.look
        styles = {"w": "wireframe", "g": "regions"}
        if key in styles:
            style = "rendered" if look.style == styles[key] else styles[key]
            director.desk = replace(desk, look=replace(look, style=style))
        elif key == "p":
            director.desk = replace(desk, look=replace(look, view=look.view.toggled("points")))
        elif key == "e":
            director.desk = replace(desk, look=replace(look, eye_contact=not look.eye_contact))
        elif key == "h":
            director.desk = replace(desk, help=not desk.help)
        elif key in ("home", "0"):
            director.desk = replace(desk, look=replace(look, view=look.view.reset()))
        elif key == "space":
            self._play(now)
        elif key == "z" and self._ctrl and desk.placing is not None:
            director.desk = replace(desk, placing=desk.placing.undo())
        flags = {"s": "picture", "r": "record", "f": "full_screen", "q": "quit", "escape": "quit"}
        if key == "escape" and _popup_open():
            return wishes
        if key == "escape" and (desk.help or desk.placing is not None):
            director.desk = replace(desk, help=False, placing=desk.placing if desk.help else None)
            return wishes
        return WindowCommands(**{**vars(wishes), flags[key]: True}) if key in flags else wishes

    def _play(self, now: float) -> None:
        director = self._director
        if director.player is not None:
            director.handle(ask.TogglePlaying(), now)
        elif director.desk.expressing.played:
            director.handle(ask.PlayExpression(director.desk.expressing.played[-1].name), now)

    def _press(self, x: float, y: float, layout: Layout, scale: float) -> None:
        if not layout.face.contains(x, y) or _popup_open():
            return
        self._pressed_at, self._moved, self._mouse = (x, y), False, (x, y)
        placing = self._director.desk.placing
        if placing is None:
            return
        self._grabbed = nearest_point(x, y, self.point_positions_px, reach=PICK_RADIUS_PX * scale)

    def _drag_point(self, layout: Layout, scale: float) -> None:
        if self._pressed_at is None:
            return
        far = np.hypot(self._mouse[0] - self._pressed_at[0], self._mouse[1] - self._pressed_at[1])
        begins, self._moved = (
            not self._moved and far > CLICK_TOLERANCE_PX * scale,
            self._moved or far > CLICK_TOLERANCE_PX * scale,
        )
        placing = self._director.desk.placing
        if self._grabbed is None or placing is None or not self._moved:
            return
        if begins:
            placing = placing.push_undo().select(self._grabbed)
        self._put(placing, self._grabbed, layout)

    def _release(self, layout: Layout) -> None:
        """End a drag; a click places the chosen point, or chooses the one it meets if that has its place already."""
        placing = self._director.desk.placing
        if placing is not None and self._pressed_at and not self._moved:
            if self._grabbed is not None and placing.placed[placing.selected]:
                self._place(placing.select(self._grabbed))
            else:
                placed = self._put(placing.push_undo(), placing.selected, layout)
                if placed:
                    self._place(placed.advance())
        self._pressed_at, self._grabbed = None, None

    def _put(self, placing: PointPlacement, point: int, layout: Layout) -> PointPlacement | None:
        """Place a point under the mouse, if there is the face."""
        director = self._director
        clip = clip_matrix(REST_POSE, director.desk.look.view, aspect=layout.face.width / layout.face.height)
        place = director.actor.picker.pick(layout.face.to_ndc(*self._mouse), clip)
        if place is None:
            return None
        mirrored = director.mirror(placing, place) if placing.mirror else None
        placing = placing.set_point(point, place, mirrored)
        self._place(placing)
        return placing

    def _place(self, placing: PointPlacement) -> None:
        self._director.desk = replace(self._director.desk, placing=placing)


def _popup_open() -> bool:
    """Tell whether a list is open: a press closes it and is not meant for the face."""
    return bool(imgui.is_popup_open("", imgui.PopupFlags_.any_popup))
