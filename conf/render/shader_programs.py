"""Shader programs, and draw calls with them: GLSL files in shaders/, with `#include "file"` for shared code."""

import re
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.render.gpu_object import GpuObject

VERSION = "#version 330\n"
_INCLUDE = re.compile(r'^#include "([\w.]+)"$', re.MULTILINE)
_CONSTANT = re.compile(r"^(const \w+ (\w+) = )([^;]+);", re.MULTILINE)


@cache
def load_source(name: str) -> str:
    """Return the GLSL of a file in shaders/ with its includes expanded, without the version line."""
    text = (files("conf.render") / "shaders" / name).read_text(encoding="utf-8")
    return _INCLUDE.sub(lambda match: load_source(match[1]), text)


def load_program(
    ctx: moderngl.Context, vertex: str, fragment: str, constants: Mapping[str, str] | None = None
) -> moderngl.Program:
    """Build a program from shaders/{vertex}.vert.glsl and shaders/{fragment}.frag.glsl.

    constants : name -> GLSL, replaces the values of the files' constants
    """
    return ctx.program(
        vertex_shader=VERSION + with_constants(load_source(f"{vertex}.vert.glsl"), constants or {}),
        fragment_shader=VERSION + with_constants(load_source(f"{fragment}.frag.glsl"), constants or {}),
    )


def with_constants(text: str, constants: Mapping[str, str]) -> str:
    """Return GLSL with other values for its constants; names that do not occur are ignored."""
    return _CONSTANT.sub(lambda match: f"{match[1]}{constants.get(match[2], match[3])};", text)


def to_column_major(matrix: NDArray[np.float64]) -> bytes:
    """Return a matrix as uniforms store it: float32, column by column."""
    return matrix.T.astype(np.float32).tobytes()


def set_matrix(program: moderngl.Program, name: str, matrix: bytes) -> None:
    """Set a matrix uniform to bytes of `to_column_major`; do nothing if the program does not use it."""
    uniform = program.get(name, None)
    if isinstance(uniform, moderngl.Uniform):
        uniform.write(matrix)


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
        members = ((name, self.program[name]) for name in self.program)
        self._uniforms = {name: member for name, member in members if isinstance(member, moderngl.Uniform)}
        indices = ctx.buffer(np.ascontiguousarray(triangles, np.int32).tobytes())
        self._array = ctx.vertex_array(self.program, attributes, indices, skip_errors=True)
        self._owned = (self._array, indices, self.program)

    def draw(self, **matrices: bytes) -> None:
        """Set the matrices, by name and as `to_column_major` returns them, and draw all triangles."""
        for name, matrix in matrices.items():
            if name in self._uniforms:
                self._uniforms[name].write(matrix)
        self._array.render(moderngl.TRIANGLES)
