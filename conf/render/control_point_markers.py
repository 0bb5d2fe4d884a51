"""Markers of the control points: a dot with its number for each point, hidden where the face is in front of it."""

import cv2
import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.render.gpu_object import GpuObject
from conf.render.shader_programs import load_program, set_matrix

GRID = (10, 5)  # columns and rows of the label atlas
CELL = 64  # pixels a side of a cell of the atlas
MARKER_SCALE = 0.56  # size of a marker in cells, in an image up to REFERENCE_HEIGHT pixels high
REFERENCE_HEIGHT = 640
DOT_RADIUS = 5  # pixels of the atlas
DOT_COLOUR = (120, 240, 255)  # sRGB
NUMBER_COLOUR = (255, 255, 255)


def render_label_atlas(count: int) -> NDArray[np.uint8]:
    """Return (H, W, 4) uint8 RGBA, first row on top: a grid of dots, each with its number to the upper right."""
    columns, rows = GRID
    colour = np.zeros((rows * CELL, columns * CELL, 3), np.uint8)
    alpha = np.zeros(colour.shape[:2], np.uint8)
    font, size = cv2.FONT_HERSHEY_DUPLEX, 0.62
    for i in range(count):
        x, y = i % columns * CELL + CELL // 2, i // columns * CELL + CELL // 2
        centre, text_origin = (x, y), (x + 2, y - 7)
        cv2.circle(alpha, centre, DOT_RADIUS + 2, 190, -1, cv2.LINE_AA)
        cv2.circle(colour, centre, DOT_RADIUS, DOT_COLOUR, -1, cv2.LINE_AA)
        cv2.circle(alpha, centre, DOT_RADIUS, 255, -1, cv2.LINE_AA)
        cv2.putText(alpha, str(i), text_origin, font, size, 170, 5, cv2.LINE_AA)
        cv2.putText(colour, str(i), text_origin, font, size, NUMBER_COLOUR, 1, cv2.LINE_AA)
        cv2.putText(alpha, str(i), text_origin, font, size, 255, 1, cv2.LINE_AA)
    return np.dstack([colour, alpha])


class ControlPointMarkers(GpuObject):
    """Markers that move with the vertices nearest to the control points."""

    def __init__(
        self, ctx: moderngl.Context, control_points: NDArray[np.float64], vertices: NDArray[np.float64]
    ) -> None:
        """control_points : (n, 3), vertices : (V, 3), both of the neutral face."""
        self._ctx = ctx
        nearest = [np.square(vertices - point).sum(axis=1).argmin() for point in control_points]
        self._nearest = np.array(nearest, np.intp)
        self._offsets = (control_points - vertices[self._nearest]).astype(np.float32)
        self._labels: moderngl.Texture | None = None  # made when they are first drawn: it takes 80 ms
        self._program = load_program(ctx, "markers", "markers")
        self._program["labels"] = 0
        self._program["depth"] = 1
        self._program["grid"] = GRID
        self._points = ctx.buffer(reserve=len(control_points) * 12)
        self._array = ctx.vertex_array(self._program, [(self._points, "3f4", "in_position")])
        self._owned = (self._array, self._points, self._program)

    def positions(self, vertices: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the (n, 3) control points of the deformed (V, 3) vertices."""
        return vertices[self._nearest] + self._offsets

    def draw(self, positions: NDArray[np.float32], clip: bytes, depth: moderngl.Texture) -> None:
        """Draw over the current framebuffer.

        positions : (n, 3), cm
        clip : clip matrix of the face, from `to_column_major`
        depth : depth of the image of the face
        """
        self._points.write(np.ascontiguousarray(positions, dtype=np.float32))
        self._ctx.enable_only(moderngl.BLEND | moderngl.PROGRAM_POINT_SIZE)
        self._label_texture().use(0)
        depth.use(1)
        set_matrix(self._program, "clip", clip)
        self._program["side"] = CELL * MARKER_SCALE * max(1.0, depth.height / REFERENCE_HEIGHT)
        self._array.render(moderngl.POINTS)

    def _label_texture(self) -> moderngl.Texture:
        if self._labels is None:
            labels = render_label_atlas(len(self._nearest))
            size = labels.shape[1], labels.shape[0]
            self._labels = self._ctx.texture(size, 4, np.ascontiguousarray(labels[::-1]).tobytes())
            self._labels.build_mipmaps()
            self._owned = (self._labels, *self._owned)
        return self._labels
