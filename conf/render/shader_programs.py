"""Shader programs: GLSL files in shaders/, with `#include "file"` for shared code."""

import re
from collections.abc import Mapping
from importlib.resources import files

import moderngl
import numpy as np
from numpy.typing import NDArray

VERSION = "#version 330\n"
_INCLUDE = re.compile(r'^#include "([\w.]+)"$', re.MULTILINE)
_CONSTANT = re.compile(r"^(const \w+ (\w+) = )([^;]+);", re.MULTILINE)


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
