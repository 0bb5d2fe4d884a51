"""`conf animate`: animate a face in a window."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from conf.commands import Terminal
from conf.commands.support.arguments import AXES

if TYPE_CHECKING:
    from conf.animator.background_fit import Axes, FitResult
    from conf.animator.controller import Controller

HELP = "a window to animate a face by hand, emotions, muscles or recordings"
SIZE = (1280, 800)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("face", type=Path, nargs="?", metavar="FACE.obj", help="default: the shipped head")
    parser.add_argument("--ppc", type=Path, help="its control points (default: the PPC file beside it, or found)")
    parser.add_argument("--up", choices=AXES, help="the mesh's axis towards the crown, if it has no points yet")
    parser.add_argument("--front", choices=AXES, help="the mesh's axis towards the nose")
    parser.add_argument("--dpc", type=Path, help="play this recording")
    parser.add_argument("--emotion", metavar="NAME", help="show an emotion: joy, surprise, doubt, ... or an EPC file")


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    axes = options.up, options.front
    animate(options.face, options.ppc, axes=axes, dpc=options.dpc, emotion=options.emotion, on_note=terminal.write)


def animate(
    face: Path | None = None,
    ppc: Path | None = None,
    *,
    axes: Axes = (None, None),
    dpc: Path | None = None,
    emotion: str | None = None,
    on_note: Callable[[str], None] = lambda text: None,
) -> None:
    """Open the animator's window and return when it is closed; on_note gets what was wrong with the mesh's file,
    and at the end the full paths of the files written.

    face : mesh, None for the shipped head
    ppc : its control points, None for the PPC file beside it or to find them
    axes : the mesh's axes towards the crown and towards the nose, such as "z" and "-y"
    dpc : a recording to play at once
    emotion : one of the six by name, or an EPC file whose first expression is played
    Raises GraphicsError, FileFormatError, ConfError.
    """
    from conf.animator.app import AnimatorApp
    from conf.animator.face_document import open_face_document
    from conf.face.animation.action_units import load_expression
    from conf.render.window.glfw_window import GlfwWindow

    document = open_face_document(face, ppc, up=axes[0], front=axes[1])
    if document.source.notes:
        on_note(f"{document.path}: {'; '.join(document.source.notes)}")
    if emotion is not None:
        load_expression(emotion)  # an error before the window opens
    with GlfwWindow(*SIZE, "conf animate") as window:
        animator = AnimatorApp(window, document, fit=fit_points)
        controller = animator.controller
        try:
            if dpc is not None:
                controller.open_file(dpc, animator.now())
            if emotion is not None:
                show_emotion(controller, emotion, animator.now())
            animator.run()
        finally:
            animator.close()
            for text in controller.reports:
                on_note(text)


def show_emotion(controller: Controller, emotion: str, now: float) -> None:
    """Play one of the six emotions by name, or the first expression of an EPC file, and hold it.

    A file's expressions replace those of the same name.
    """
    from conf.face.animation.action_units import load_emotions, load_expression

    if emotion not in load_emotions().names:
        controller.open_file(Path(emotion), now)
    expression = replace(controller.state.expression, hold_until_released=True)
    controller.state = replace(controller.state, expression=expression)
    controller.play_expression(load_expression(emotion).names[0], now)


def fit_points(path: Path, axes: Axes, on_progress: Callable[[float, str], None], /) -> FitResult:
    """Return the control points of a mesh file, as `conf fit` finds them. Raises ConfError if it shows no face."""
    from conf.animator.background_fit import FitResult
    from conf.mesh_fitting.fit import find_points

    fitted, _, remarks = find_points(path, axes, on_progress)
    return FitResult(fitted.points, remarks)
