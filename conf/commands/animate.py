"""`conf animate`: the animator's window."""

from dataclasses import replace
from pathlib import Path

from conf.animator.app import Animator
from conf.animator.requests import Open, Play
from conf.animator.subject import open_subject
from conf.errors import ConfError
from conf.face.action_units import load_emotions
from conf.face.epc import read_epc
from conf.receiver.window import GlfwWindow

SIZE = (1280, 800)


def animate(
    face: Path | None = None, *, ppc: Path | None = None, dpc: Path | None = None, emotion: str | None = None
) -> None:
    """Open the window and stay until it is closed.

    face : mesh, None for the shipped head; ppc : its control points; dpc : a recording to play at once
    emotion : one of the six by name, or an EPC file whose first expression plays
    Raises GraphicsError, FileFormatError, ConfError.
    """
    subject = open_subject(face, ppc)
    name = _emotion_name(emotion)
    with GlfwWindow(*SIZE, "conf animate") as window:
        animator = Animator(window, subject)
        try:
            if dpc is not None:
                animator.request(Open(dpc))
            if emotion is not None and name not in load_emotions().names:
                animator.request(Open(Path(emotion)))
            if name is not None:
                desk = animator.director.desk
                animator.director.desk = replace(desk, expressing=replace(desk.expressing, stays=True))
                animator.request(Play(name))
            animator.run()
        finally:
            animator.close()


def _emotion_name(emotion: str | None) -> str | None:
    """Return the name of the expression that is to play."""
    if emotion is None or emotion in load_emotions().names:
        return emotion
    if not emotion.lower().endswith(".epc"):
        names = ", ".join(load_emotions().names)
        raise ConfError(f"there is no emotion {emotion!r}: choose one of {names}, or give an .epc file")
    return read_epc(emotion).names[0]
