"""The animator's window: the loop that takes what the user does, moves the face and draws it."""

import math
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conf.animator.background_fit import Fit
from conf.animator.commands import Open, Request
from conf.animator.controller import Director
from conf.animator.face_document import Subject
from conf.animator.face_instance import Actor
from conf.animator.gui.layout import Layout, scale_of
from conf.animator.gui.main import Interface
from conf.animator.gui.theme import BACKDROP, themed
from conf.animator.motion_mixer import Moment, moment
from conf.animator.motion_player import REST_POSE
from conf.animator.state.editor import Facts
from conf.animator.state.expression import Expressing
from conf.animator.viewport_controller import Touch, Wishes
from conf.errors import ConfError
from conf.face.animation.idle_motion import IdleMotion
from conf.face.deformation.face_model import Deformer
from conf.output.media_writer import ClipRecorder, free_name
from conf.receiver.participant_grid import Window
from conf.render.ui.imgui_input import Hands, dropped_files
from conf.render.ui.imgui_overlay import Overlay

FPS = 60.0
CLIP_FPS = 30.0
STEADY = 0.05  # share of the newest frame in the frame rate that is shown


class Animator:
    """One window. Run it until its user goes."""

    def __init__(self, window: Window, subject: Subject, folder: Path | None = None, *, fit: Fit | None = None) -> None:
        """Begin with a subject; one without control points is searched for them if `fit` is given.

        folder : where pictures and clips of the keys S and R go; None takes the current one
        """
        window.keys_close = False
        self._window = window
        self._overlay = Overlay(window.ctx)
        self._interface = Interface(self._overlay)
        self.director = Director(window.ctx, Actor(window.ctx, subject, Deformer()), fit)
        self._touch = Touch(self.director)
        self._hands = Hands()
        self._idle = IdleMotion(np.random.default_rng())
        self._folder = folder or Path()
        self._began = time.monotonic()
        self._last, self._period = 0.0, 1 / FPS
        self._clip: ClipRecorder | None = None
        self._clip_began = 0.0
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
        self.director.carry_out(request, self._now())

    def draw_frame(self) -> None:
        """Take what happened, draw one picture."""
        now = self._now()
        self._period += STEADY * (now - self._last - self._period)
        self._last = now
        window, director = self._window, self.director
        events = window.poll()
        scale = scale_of(window.size, window.pixel_ratio)
        layout = Layout.of(window.size, scale)
        self._hands.feed(events)
        wishes = self._touch.take(events, layout, scale, now)
        for path in dropped_files(events):
            director.carry_out(Open(Path(path)), now)
        director.actor.follow(director.desk.deformer, director.desk.muscling)
        director.desk = replace(director.desk, expressing=director.desk.expressing.settled(now))
        self._interface.prepare(director)
        window.begin(BACKDROP)
        self._draw_face(layout, now)
        self._record(layout, now)
        with self._overlay.frame(window.framebuffer, window.size, window.pixel_ratio, scale=scale), themed(scale):
            requests = self._interface.draw(director, self._touch, layout, self._facts(now))
        for request in requests:
            director.carry_out(request, now)
        self._grant(wishes, layout, now)
        director.go_on()
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

    def _facts(self, now: float) -> Facts:
        director = self.director
        actor = director.actor
        return Facts(
            now,
            actor.subject,
            director.player,
            director.emotions,
            smoothing=actor.face.smoothing,
            build_ms=actor.built.milliseconds,
            busy=actor.busy,
            taking=director.take is not None,
            fits=director.fitting.possible,
            fitting=director.fitting.progress,
            progress=director.progress,
            fps=1 / max(self._period, 1e-3),
            vertices=len(actor.face.mesh.vertices),
        )

    def _draw_face(self, layout: Layout, now: float) -> None:
        director, framebuffer = self.director, self._window.framebuffer
        vertices, happening = self._moved(now)
        director.shown = (vertices, happening)
        framebuffer.viewport = layout.face_viewport(self._window.size[1])
        director.actor.picture.draw(vertices, happening.pose, director.desk.look, framebuffer)
        framebuffer.viewport = (0, 0, *self._window.size)

    def _moved(self, now: float) -> tuple[NDArray[np.float32], Moment]:
        """Return the (V, 3) vertices and what moves them."""
        director = self.director
        desk, actor = director.desk, director.actor
        still = np.zeros((len(actor.face.control_points), 3), np.float32)
        if desk.placing is not None or actor.subject.points is None:
            return actor.face.neutral, Moment(still, REST_POSE)
        if desk.muscling.active:
            life = moment(None, Expressing(idle=desk.expressing.idle), self._idle, desk.look, now)
            by_muscles = actor.by_muscles(desk.muscling)
            pulled = 0.0 if by_muscles is None else by_muscles - actor.face.neutral
            return actor.face.deform(life.displacements) + pulled, life
        happening = moment(director.player, desk.expressing, self._idle, desk.look, now)
        if director.take is not None:
            director.take.add(happening.displacements, happening.pose, now)
        return actor.face.deform(happening.displacements), happening

    def _grant(self, wishes: Wishes, layout: Layout, now: float) -> None:
        """Do what keys ask of the window itself."""
        if wishes.quit:
            self._window.should_close = True
        if wishes.full_screen:
            self._window.toggle_full_screen()
        try:
            if wishes.picture:
                self.director.save_shown(self._folder)
            if wishes.record:
                self._toggle_clip(now)
        except ConfError as error:
            self.director.notice = str(error)

    def _toggle_clip(self, now: float) -> None:
        if self._clip is None:
            self._clip = ClipRecorder(free_name(self._folder, "conf", ".avi"), fps=CLIP_FPS)
            self._clip_began = now
            self.director.notice = "recording what you see; R stops"
        else:
            clip, self._clip = self._clip, None
            self.director.notice = f"saved {clip.close()}"

    def _record(self, layout: Layout, now: float) -> None:
        """Write the face's part of the picture as often as the clip's rate asks for."""
        if self._clip is None:
            return
        due = math.floor((now - self._clip_began) * CLIP_FPS) + 1
        if self._clip.frames < due:
            x, y, width, height = layout.face_viewport(self._window.size[1])
            bottom = self._window.size[1] - y
            pixels = self._window.read()[bottom - height : bottom, x : x + width]
            while self._clip.frames < due:
                self._clip.write(np.ascontiguousarray(pixels))
