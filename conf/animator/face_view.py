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


class FaceView:
    """Draws one mesh; its operator may change."""

    def __init__(self, ctx: moderngl.Context, face: FaceModel) -> None:
        self.face = face  # may be replaced by one with another operator of the same mesh and control points
        self._ctx = ctx
        self._renderer = FaceRenderer(ctx, face)
        self._lights = "studio"
        self._coloured: tuple[int, int | None] | None = None  # id of the face, and influence, whose colours are set

    def draw(
        self, vertices: NDArray[np.float32], pose: HeadPose, view: ViewSettings, framebuffer: moderngl.Framebuffer
    ) -> None:
        """Draw (V, 3) vertices, face axes, cm, into the framebuffer's viewport."""
        if view.lights != self._lights:  # lights are shader constants: new ones need a new renderer
            self._renderer.release()
            self._renderer = FaceRenderer(self._ctx, self.face, lighting=LIGHTS[view.lights])
            self._lights, self._coloured = view.lights, None
        self._renderer.background = view.background
        self._set_colours(view)
        points = view.camera.points and view.style != "regions"
        camera = replace(view.camera, wireframe=view.style == "wireframe", points=points)
        self._renderer.draw(vertices, pose, camera, framebuffer)

    def visible(self, positions: NDArray[np.floating], clip: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell which of (k, 3) positions the face does not hide in the frame drawn last under this clip matrix."""
        target = self._renderer.target
        return np.ones(len(positions), np.bool_) if target is None else target.visible(positions, clip)

    def release(self) -> None:
        """Free all GPU objects."""
        self._renderer.release()

    def _set_colours(self, view: ViewSettings) -> None:
        coloured = (id(self.face), view.influence) if view.style == "regions" else None
        if coloured == self._coloured:
            return
        self._coloured, operator = coloured, self.face.operator
        if coloured is None:
            self._renderer.set_colours(None)
        elif view.influence is None:
            self._renderer.set_colours(region_colours(operator))
        else:
            self._renderer.set_colours(point_colours(operator, view.influence))
