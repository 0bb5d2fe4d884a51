"""Shaders: GLSL files beside this module, with `#include "file"` for what they share."""

import re
from importlib.resources import files

import moderngl
import numpy as np
from numpy.typing import NDArray

VERSION = "#version 330\n"
_INCLUDE = re.compile(r'^#include "([\w.]+)"$', re.MULTILINE)


def source(name: str) -> str:
    """Return the GLSL of a file in shaders/, its includes put in, without the version line."""
    text = (files("conf.receiver") / "shaders" / name).read_text(encoding="utf-8")
    return _INCLUDE.sub(lambda match: source(match[1]), text)


def program(ctx: moderngl.Context, vertex: str, fragment: str) -> moderngl.Program:
    """Build a program from shaders/{vertex}.vert.glsl and shaders/{fragment}.frag.glsl."""
    return ctx.program(
        vertex_shader=VERSION + source(f"{vertex}.vert.glsl"),
        fragment_shader=VERSION + source(f"{fragment}.frag.glsl"),
    )


def columns(matrix: NDArray[np.float64]) -> bytes:
    """Return a matrix as shaders take it: float32, column after column."""
    return matrix.T.astype(np.float32).tobytes()


def set_matrix(step: moderngl.Program, name: str, matrix: bytes) -> None:
    """Give a program a matrix from `columns`; a program that does not use it is left alone."""
    uniform = step.get(name, None)
    if isinstance(uniform, moderngl.Uniform):
        uniform.write(matrix)
