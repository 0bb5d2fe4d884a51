"""The animator's window: the loop that takes what the user does, moves the face and draws it."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.animator.background_fit import FitFunction
from conf.animator.commands import OpenFile, Request
from conf.animator.controller import Controller
from conf.animator.face_document import FaceDocument
from conf.animator.face_instance import FaceInstance
from conf.animator.gui.layout import Layout, scale_of
from conf.animator.gui.main import AnimatorGui
from conf.animator.gui.theme import BACKDROP, themed
from conf.animator.motion_mixer import MotionSample, mix_motion
from conf.animator.motion_player import REST_POSE
from conf.animator.state.editor import StatusInfo
from conf.animator.state.expression import ExpressionState
from conf.animator.viewport_controller import ViewportController, WindowCommands
from conf.errors import ConfError
from conf.face.animation.idle_motion import IdleMotion
from conf.face.deformation.face_model import DeformerOptions
from conf.output.media_writer import VideoWriter, next_free_path
from conf.render.ui.imgui_input import ImGuiInput, dropped_files
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window import Window

FPS = 60.0
CLIP_FPS = 30.0
FPS_SMOOTHING = 0.05  # share of the newest frame in the frame rate that is shown


class AnimatorApp:
    """One window. Run it until its user goes."""

    def __init__(
        self, window: Window, subject: FaceDocument, folder: Path | None = None, *, fit: FitFunction | None = None
    ) -> None:
        """Begin with a subject; one without control points is searched for them if `fit` is given.

        folder : where pictures and clips of the keys S and R go; None takes the current one
        """
        window.close_on_escape = False
        self._window = window
        self._overlay = ImGuiOverlay(window.ctx)
        self._interface = AnimatorGui(self._overlay)
        self.director = Controller(window.ctx, FaceInstance(window.ctx, subject, DeformerOptions()), fit)
        self._touch = ViewportController(self.director)
        self._hands = ImGuiInput()
        self._idle = IdleMotion(np.random.default_rng())
        self._folder = folder or Path()
        self._began = time.monotonic()
        self._last, self._period = 0.0, 1 / FPS
        self._clip: VideoWriter | None = None
        self.director.find_missing_points()

    def run(self) -> None:
        """Draw until the window is closed."""
        while not self._window.should_close:
            self.draw_frame()
            left = self._last + 1 / FPS - self._now()
            if left > 0:
                time.sleep(left)

    def request(self, request: Request) -> None:
        """Do what a panel would have asked for."""
        self.director.handle(request, self._now())

    def draw_frame(self) -> None:
        """Take what happened, draw one picture."""
        now = self._now()
        self._period += FPS_SMOOTHING * (now - self._last - self._period)
        self._last = now
        window, director = self._window, self.director
        events = window.poll()
        scale = scale_of(window.size, window.pixel_ratio)
        layout = Layout.of(window.size, scale)
        self._hands.process_events(events)
        wishes = self._touch.process_events(events, layout, scale, now)
        for path in dropped_files(events):
            director.handle(OpenFile(Path(path)), now)
        director.actor.update(director.desk.deformer, director.desk.muscling)
        director.desk = replace(director.desk, expressing=director.desk.expressing.without_finished(now))
        self._interface.prepare(director)
        window.begin(BACKDROP)
        self._draw_face(layout, now)
        self._record(layout, now)
        with self._overlay.frame(window, scale=scale), themed(scale):
            requests = self._interface.draw(director, self._touch, layout, self._status(now))
        for request in requests:
            director.handle(request, now)
        self._run_window_commands(wishes, layout, now)
        director.update()
        window.end()

    def close(self) -> None:
        """Finish a recording, free everything."""
        if self._clip is not None:
            self._clip.close()
        self._interface.release()
        self.director.release()
        self._overlay.release()

    def _now(self) -> float:
        return time.monotonic() - self._began

    def _status(self, now: float) -> StatusInfo:
        director = self.director
        actor = director.actor
        return StatusInfo(
            now,
            actor.subject,
            director.player,
            director.emotions,
            smoothing=actor.face.smoothing,
            build_ms=actor.built.milliseconds,
            busy=actor.busy,
            recording=director.recorder is not None,
            can_fit=director.fitting.available,
            fitting=director.fitting.progress,
            progress=director.progress,
            fps=1 / max(self._period, 1e-3),
            vertices=len(actor.face.mesh.vertices),
        )

    def _draw_face(self, layout: Layout, now: float) -> None:
        director, framebuffer = self.director, self._window.framebuffer
        vertices, happening = self._deformed(now)
        director.last_frame = (vertices, happening)
        framebuffer.viewport = layout.face_viewport(self._window.size[1])
        director.actor.picture.draw(vertices, happening.pose, director.desk.look, framebuffer)
        framebuffer.viewport = (0, 0, *self._window.size)

    def _deformed(self, now: float) -> tuple[NDArray[np.float32], MotionSample]:
        """Return the (V, 3) vertices and what moves them."""
        director = self.director
        desk, actor = director.desk, director.actor
        still = np.zeros((len(actor.face.control_points), 3), np.float32)
        if desk.placing is not None or actor.subject.points is None:
            return actor.face.neutral, MotionSample(still, REST_POSE)
        if desk.muscling.active:
            life = mix_motion(None, ExpressionState(idle=desk.expressing.idle), self._idle, desk.look, now)
            by_muscles = actor.muscle_vertices(desk.muscling)
            pulled = 0.0 if by_muscles is None else by_muscles - actor.face.neutral
            return actor.face.deform(life.displacements) + pulled, life
        happening = mix_motion(director.player, desk.expressing, self._idle, desk.look, now)
        if director.recorder is not None:
            director.recorder.add(happening.displacements, happening.pose.to_vector(), now)
        return actor.face.deform(happening.displacements), happening

    def _run_window_commands(self, wishes: WindowCommands, layout: Layout, now: float) -> None:
        """Do what keys ask of the window itself."""
        if wishes.quit:
            self._window.should_close = True
        if wishes.full_screen:
            self._window.toggle_full_screen()
        try:
            if wishes.picture:
                self.director.save_screenshot(self._folder)
            if wishes.record:
                self._toggle_clip(now)
        except ConfError as error:
            self.director.notice = str(error)

    def _toggle_clip(self, now: float) -> None:
        if self._clip is None:
            self._clip = VideoWriter(next_free_path(self._folder, "conf", ".avi"), fps=CLIP_FPS)
            self.director.notice = "recording what you see; R stops"
        else:
            clip, self._clip = self._clip, None
            self.director.notice = f"saved {clip.close()}"

    def _record(self, layout: Layout, now: float) -> None:
        """Write the face's part of the picture as often as the clip's rate asks for."""
        if self._clip is None:
            return
        x, y, width, height = layout.face_viewport(self._window.size[1])
        bottom = self._window.size[1] - y
        face = slice(bottom - height, bottom), slice(x, x + width)
        self._clip.write_at(lambda: np.ascontiguousarray(self._window.read()[face]), now)
