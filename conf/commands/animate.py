"""`conf animate`: the animator's window."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from conf.animator.app import AnimatorApp
from conf.animator.background_fit import FitResult
from conf.animator.commands import OpenFile, PlayExpression
from conf.animator.face_document import open_face_document
from conf.errors import ConfError
from conf.face.animation.action_units import load_emotions
from conf.face.formats.epc import read_epc
from conf.face.formats.ppc import read_ppc
from conf.mesh_fitting.fit import fit
from conf.render.window.glfw_window import GlfwWindow

SIZE = (1280, 800)


@dataclass(frozen=True)
class FaceOptions:
    """Who is animated.

    face : mesh, None for the shipped head; ppc : its control points, None for those beside it or to find them
    up, front : the mesh's axes towards the crown and towards the nose, such as "z" and "-y"
    """

    face: Path | None = None
    ppc: Path | None = None
    up: str | None = None
    front: str | None = None


def animate(sitter: FaceOptions, *, dpc: Path | None = None, emotion: str | None = None) -> None:
    """Open the window and stay until it is closed.

    dpc : a recording to play at once
    emotion : one of the six by name, or an EPC file whose first expression plays
    Raises GraphicsError, FileFormatError, ConfError.
    """
    subject = open_face_document(sitter.face, sitter.ppc, up=sitter.up, front=sitter.front)
    name = _emotion_name(emotion)
    with GlfwWindow(*SIZE, "conf animate") as window:
        animator = AnimatorApp(window, subject, fit=fit_points)
        try:
            if dpc is not None:
                animator.request(OpenFile(dpc))
            if emotion is not None and name not in load_emotions().names:
                animator.request(OpenFile(Path(emotion)))
            if name is not None:
                desk = animator.director.desk
                animator.director.desk = replace(desk, expressing=replace(desk.expressing, hold_until_released=True))
                animator.request(PlayExpression(name))
            animator.run()
        finally:
            animator.close()


def fit_points(path: Path, axes: tuple[str | None, str | None], on_progress: Callable[[str], None], /) -> FitResult:
    """Let `conf fit` find the control points of a mesh file. Raises ConfError if there is no face in it."""
    with TemporaryDirectory(prefix="conf-fit-") as folder:
        output = Path(folder) / "found.ppc"
        report = fit(path, output, up=axes[0], front=axes[1], on_progress=on_progress)
        return FitResult(read_ppc(output), report.remarks)


def _emotion_name(emotion: str | None) -> str | None:
    """Return the name of the expression that is to play."""
    if emotion is None or emotion in load_emotions().names:
        return emotion
    if not emotion.lower().endswith(".epc"):
        names = ", ".join(load_emotions().names)
        raise ConfError(f"there is no emotion {emotion!r}: choose one of {names}, or give an .epc file")
    return read_epc(emotion).names[0]
