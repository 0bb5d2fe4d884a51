"""A shader program together with the triangles that it draws."""

from collections.abc import Mapping
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.render.gpu_object import GpuObject
from conf.render.shader_programs import load_program, set_matrix


class DrawCall(GpuObject):
    """Indexed triangles over shared vertex buffers."""

    def __init__(
        self,
        ctx: moderngl.Context,
        shaders: tuple[str, str],
        attributes: list[Any],
        triangles: NDArray[np.integer],
        constants: Mapping[str, str] | None = None,
    ) -> None:
        """Build the program and upload the indices.

        shaders : names of the vertex and the fragment shader
        attributes : buffers with format and names, as `moderngl.Context.vertex_array` takes them; attributes that
            the shaders do not use are skipped
        triangles : (F, 3) indices into the buffers
        constants : name -> GLSL, replaces constants of the shaders
        """
        self.program = load_program(ctx, *shaders, constants)
        indices = ctx.buffer(np.ascontiguousarray(triangles, np.int32).tobytes())
        self._array = ctx.vertex_array(self.program, attributes, indices, skip_errors=True)
        self._owned = (self._array, indices, self.program)

    def draw(self, **matrices: bytes) -> None:
        """Set the matrices, by name and as `to_column_major` returns them, and draw all triangles."""
        for name, matrix in matrices.items():
            set_matrix(self.program, name, matrix)
        self._array.render(moderngl.TRIANGLES)
