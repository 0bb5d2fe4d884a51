"""Draw a face in any style into any framebuffer, for the window and for exports."""

from dataclasses import replace

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.animator.gui.influence_colours import point_colours, region_colours
from conf.animator.state.editor import ViewSettings
from conf.face.deformation.face_model import FaceModel
from conf.face.head_pose import HeadPose
from conf.render.face_renderer import FaceRenderer
from conf.render.lighting import LIGHTS
from conf.render.render_target import RenderTarget
from conf.render.vertex_colour_renderer import VertexColourRenderer


class FaceView:
    """Draws one mesh; its operator may change."""

    def __init__(self, ctx: moderngl.Context, face: FaceModel) -> None:
        self._ctx = ctx
        self._face = face
        self._renderer = FaceRenderer(ctx, face)
        self._lights = "studio"
        self._colour_renderer: VertexColourRenderer | None = None
        self._colour_key: tuple[int, int | None] | None = None
        self._colour_target: RenderTarget | None = None
        self._last_target: RenderTarget | None = None  # set if the last frame was drawn in the style "regions"

    def set_face(self, face: FaceModel) -> None:
        """Use another operator of the same mesh and control points."""
        self._face = face
        self._colour_key = None

    def draw(
        self, vertices: NDArray[np.float32], pose: HeadPose, view: ViewSettings, framebuffer: moderngl.Framebuffer
    ) -> None:
        """Draw (V, 3) vertices, face axes, cm, into the framebuffer's viewport."""
        if view.style != "regions":
            self._set_lights(view)
            camera = replace(view.camera, wireframe=view.style == "wireframe")
            self._renderer.draw(vertices, pose, camera, framebuffer)
            self._last_target = None
            return
        _, _, width, height = framebuffer.viewport
        self._last_target = target = self._target_for((width, height), view.background)
        renderer = self._coloured_renderer(view.influence)
        target.begin()
        renderer.draw(vertices, pose, view.camera, target)
        target.resolve(framebuffer)

    def visible(self, positions: NDArray[np.floating], clip: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell which of (k, 3) positions the face does not hide in the frame drawn last under this clip matrix."""
        target = self._last_target or self._renderer.target
        return np.ones(len(positions), np.bool_) if target is None else target.visible(positions, clip)

    def release(self) -> None:
        """Free all GPU objects."""
        for resource in (self._renderer, self._colour_renderer, self._colour_target):
            if resource is not None:
                resource.release()

    def _coloured_renderer(self, influence: int | None) -> VertexColourRenderer:
        if self._colour_renderer is None:
            self._colour_renderer = VertexColourRenderer(self._ctx, self._face.mesh)
        key = (id(self._face), influence)
        if self._colour_key != key:
            operator = self._face.operator
            colours = region_colours(operator) if influence is None else point_colours(operator, influence)
            self._colour_renderer.set_colours(colours)
            self._colour_key = key
        return self._colour_renderer

    def _set_lights(self, view: ViewSettings) -> None:
        """Change lights and background. Lights are shader constants, so new ones need a new renderer."""
        if view.lights != self._lights:
            self._renderer.release()
            self._renderer = FaceRenderer(self._ctx, self._face, lighting=LIGHTS[view.lights])
            self._lights = view.lights
        self._renderer.background = view.background

    def _target_for(self, size: tuple[int, int], background: str) -> RenderTarget:
        target = self._colour_target
        if target is None or (target.size, target.background) != (size, background):
            if target is not None:
                target.release()
            self._colour_target = target = RenderTarget(self._ctx, size, background)
        return target
