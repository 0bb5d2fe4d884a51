"""One picture of a face in any style, into any framebuffer: what the window shows and what exports write."""

from dataclasses import replace

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.animator.gui.influence_colours import point_colours, region_colours
from conf.animator.state.view_settings import ViewSettings
from conf.face.deformation.face_model import FaceModel
from conf.face.head_pose import HeadPose
from conf.render.face_renderer import FaceRenderer
from conf.render.lighting import LIGHTS
from conf.render.render_target import RenderTarget
from conf.render.vertex_colour_renderer import VertexColourRenderer


class FaceView:
    """Draws one mesh; the operator that moves it may change."""

    def __init__(self, ctx: moderngl.Context, face: FaceModel) -> None:
        self._ctx = ctx
        self._face = face
        self._renderer = FaceRenderer(ctx, face)
        self._lights = "studio"
        self._tinted: VertexColourRenderer | None = None
        self._canvas: RenderTarget | None = None
        self._colour_key: tuple[int, int | None] | None = None
        self._drawn: RenderTarget | None = None  # the canvas of the regions, if these were drawn last

    def set_face(self, face: FaceModel) -> None:
        """Go on with another operator on the same mesh and control points."""
        self._face = face
        self._colour_key = None

    def draw(
        self, vertices: NDArray[np.float32], pose: HeadPose, look: ViewSettings, framebuffer: moderngl.Framebuffer
    ) -> None:
        """Draw (V, 3) vertices, face axes, cm, into the framebuffer's viewport."""
        if look.style != "regions":
            self._set_light(look)
            view = replace(look.view, wireframe=look.style == "wireframe")
            self._renderer.draw(vertices, pose, view, framebuffer)
            self._drawn = None
            return
        _, _, width, height = framebuffer.viewport
        self._drawn = canvas = self._canvas_of((width, height), look.background)
        tinted = self._tinted_face(look.influence)
        canvas.begin()
        tinted.draw(vertices, pose, look.view, canvas)
        canvas.resolve(framebuffer)

    def visible(self, places: NDArray[np.floating], clip: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell which of (k, 3) places of the face are not hidden in the picture drawn last, under its clip matrix."""
        canvas = self._renderer.target if self._drawn is None else self._drawn
        return np.ones(len(places), np.bool_) if canvas is None else canvas.visible(places, clip)

    def release(self) -> None:
        """Free everything on the card."""
        for thing in (self._renderer, self._tinted, self._canvas):
            if thing is not None:
                thing.release()

    def _tinted_face(self, influence: int | None) -> VertexColourRenderer:
        if self._tinted is None:
            self._tinted = VertexColourRenderer(self._ctx, self._face.mesh)
        key = (id(self._face), influence)
        if self._colour_key != key:
            operator = self._face.operator
            self._tinted.set_colours(
                region_colours(operator) if influence is None else point_colours(operator, influence)
            )
            self._colour_key = key
        return self._tinted

    def _set_light(self, look: ViewSettings) -> None:
        """Hang the lights: shaders know theirs as constants, so a change builds them again."""
        if look.lights != self._lights:
            self._renderer.release()
            self._renderer = FaceRenderer(self._ctx, self._face, lighting=LIGHTS[look.lights])
            self._lights = look.lights
        self._renderer.background = look.background

    def _canvas_of(self, size: tuple[int, int], background: str) -> RenderTarget:
        if self._canvas is None or (self._canvas.size, self._canvas.background) != (size, background):
            if self._canvas is not None:
                self._canvas.release()
            self._canvas = RenderTarget(self._ctx, size, background)
        return self._canvas
