"""Shaders: GLSL files beside this module, with `#include "file"` for what they share."""

import re
from importlib.resources import files

import moderngl

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
