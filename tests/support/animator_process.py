"""The animator as a process for tests: after each frame it answers a line on stdin with its state as JSON.

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

WIDGETS = ("button", "radio_button", "checkbox", "slider_float", "combo", "begin_tab_item_simple", "input_text",
           "input_text_with_hint", "invisible_button")  # fmt: skip
widget_rects: dict[str, tuple[float, float, float, float]] = {}


def record_rects(name: str) -> None:
    """Record the rectangle of each widget of a kind by its label."""
    original: Callable[..., Any] = getattr(imgui, name)

    def record(label: str, *arguments: Any, **options: Any) -> Any:
        result = original(label, *arguments, **options)
        low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        widget_rects[label] = (low.x, low.y, high.x, high.y)
        return result

    setattr(imgui, name, record)


def report(animator: AnimatorApp, window: GlfwWindow) -> dict[str, Any]:
    """Return the state that the tests check."""
    controller = animator.controller
    state, face, player = controller.state, controller.face, controller.player
    document, now = face.document, animator.now()
    vertices, sample = controller.deform(now)
    layout = Layout.of(window.size, 1.0)
    clip = clip_matrix(REST_POSE, state.view.camera, aspect=layout.face.width / layout.face.height)
    return {
        "widgets": widget_rects,
        "camera": {"yaw": state.view.camera.yaw, "zoom": state.view.camera.zoom},
        "style": state.view.style,
        "kernel": state.deformer.kernel,
        "build": {"ms": face.build_ms, "smoothing": face.model.smoothing, "busy": face.busy},
        "muscles": state.muscles.active,
        "moved_cm": float(np.abs(vertices - face.model.neutral).max()),
        "displacement": float(np.abs(sample.displacements).max()),
        "placement": None if state.placement is None else [state.placement.selected, state.placement.missing],
        "points": None if document.points is None else document.points.tolist(),
        "file_to_model": [document.file_to_model.scale, document.file_to_model.translation.tolist()],
        "clip": clip.tolist(),
        "rect": [layout.face.x, layout.face.y, layout.face.width, layout.face.height],
        "player": None if player is None else [player.position(now), player.is_playing(now),
                                               player.speed, player.loop],
        "export_progress": controller.export_progress,
        "source": state.fields.source,
        "fields": list(vars(state.fields).values()),
        "notice": animator._gui.notice,
        "fps": animator.fps,
    }  # fmt: skip


def main() -> None:
    """Draw until the window or stdin is closed."""
    for name in WIDGETS:
        record_rects(name)
    document = open_face_document(Path(sys.argv[2]) if len(sys.argv) > 2 else None)
    with GlfwWindow(1280, 800, "conf animator test") as window:
        animator = AnimatorApp(window, document, Path(sys.argv[1]))
        while not window.should_close:
            animator.draw_frame()
            if select.select([sys.stdin], [], [], 0.0)[0]:
                if not sys.stdin.readline():
                    break
                sys.stdout.write(json.dumps(report(animator, window)) + "\n")
                sys.stdout.flush()
        animator.close()


if __name__ == "__main__":
    main()
