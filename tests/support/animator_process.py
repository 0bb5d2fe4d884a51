"""The animator as a program for tests: answers each line on stdin with where its widgets are and what it shows.

python -m tests.support.animator_process FOLDER [FACE.obj]
"""

import json
import select
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from imgui_bundle import imgui

from conf.animator.app import AnimatorApp
from conf.animator.face_document import open_face_document
from conf.animator.gui.layout import Layout
from conf.animator.motion_player import REST_POSE
from conf.render.camera import clip_matrix
from conf.render.window.glfw_window import GlfwWindow

WATCHED = ("button", "radio_button", "checkbox", "slider_float", "combo", "begin_tab_item_simple", "input_text",
           "input_text_with_hint", "invisible_button")  # fmt: skip
places: dict[str, tuple[float, float, float, float]] = {}


def watch(name: str) -> None:
    """Note where each widget of a kind is drawn, by its label."""
    original: Callable[..., Any] = getattr(imgui, name)

    def noting(label: str, *rest: Any, **more: Any) -> Any:
        answer = original(label, *rest, **more)
        low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        places[label] = (low.x, low.y, high.x, high.y)
        return answer

    setattr(imgui, name, noting)


def facts(animator: AnimatorApp, window: GlfwWindow) -> dict[str, Any]:
    """Return what a test wants to know."""
    director = animator.director
    desk, face = director.desk, director.actor.face
    vertices, moment = director.last_frame or (face.neutral, None)
    layout = Layout.of(window.size, 1.0)
    clip = clip_matrix(REST_POSE, desk.look.view, aspect=layout.face.width / layout.face.height)
    player = director.player
    now = animator._now()
    return {
        "places": places,
        "view": {"yaw": desk.look.view.yaw, "zoom": desk.look.view.zoom},
        "style": desk.look.style,
        "kernel": desk.deformer.kernel,
        "built": [director.actor.built.milliseconds, face.smoothing, director.actor.busy],
        "muscles": desk.muscling.active,
        "moved_cm": float(np.abs(vertices - face.neutral).max()),
        "mouth_cm": float(np.abs(moment.displacements).max()) if moment else 0.0,
        "placing": None if desk.placing is None else [desk.placing.selected, desk.placing.missing],
        "points": None if director.actor.subject.points is None else director.actor.subject.points.tolist(),
        "scale": [director.actor.subject.placement.scale, director.actor.subject.placement.translation.tolist()],
        "clip": clip.tolist(),
        "rect": [layout.face.x, layout.face.y, layout.face.width, layout.face.height],
        "player": None if player is None else [player.clock.position(now), player.clock.is_playing(now),
                                               player.clock.speed, player.clock.loop],
        "progress": director.progress,
        "source": desk.fields.source,
        "fields": list(vars(desk.fields).values()),
        "notice": animator._interface._notice,
        "fps": 1 / animator._period,
    }  # fmt: skip


def main() -> None:
    """Draw until the window is closed, answer a line a frame."""
    for name in WATCHED:
        watch(name)
    subject = open_face_document(Path(sys.argv[2]) if len(sys.argv) > 2 else None)
    with GlfwWindow(1280, 800, "conf animator test") as window:
        animator = AnimatorApp(window, subject, Path(sys.argv[1]))
        slowest = 0.0
        while not window.should_close:
            before = animator._now()
            animator.draw_frame()
            slowest = max(slowest, animator._now() - before)
            if select.select([sys.stdin], [], [], 0.0)[0]:
                if not sys.stdin.readline():
                    break
                sys.stdout.write(json.dumps({**facts(animator, window), "slowest_ms": 1e3 * slowest}) + "\n")
                sys.stdout.flush()
                slowest = 0.0
        animator.close()


if __name__ == "__main__":
    main()
