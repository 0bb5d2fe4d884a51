"""A process with a window, for test_glfw_window: draws the stand-in face, prints each event as a line of JSON.

python -m tests.support.window_process IMAGE.png
"""

import json
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np

from conf.face.deformation.face_model import FaceModel
from conf.face.head_pose import HeadPose
from conf.output.image_writer import save_image
from conf.receiver.viewer_controls import action_of, apply_view_event, help_lines
from conf.render.camera import ViewState
from conf.render.face_renderer import FaceRenderer
from conf.render.ui.hud import draw_help
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.glfw_window import GlfwWindow
from tests.support.stand_in_head import control_points, stand_in_mesh

POSE = HeadPose(np.zeros(3), np.zeros(2), float(np.log(0.03)))


def report(**fields: object) -> None:
    """Print one line for the test to read."""
    sys.stdout.write(json.dumps(fields) + "\n")
    sys.stdout.flush()


def main() -> None:
    """Draw until Q is pressed; S saves the image."""
    mesh, points = stand_in_mesh(), control_points()
    face = FaceModel(mesh, points, np.zeros((len(mesh.vertices), 50), np.float32))
    view, save_requested = ViewState(), False
    with (
        GlfwWindow(320, 240, "conf test") as window,
        FaceRenderer(window.ctx, face) as renderer,
        ImGuiOverlay(window.ctx) as overlay,
    ):
        size = (0, 0)
        while not window.should_close:
            events = window.poll()
            for event in events:
                view = apply_view_event(view, event)
                save_requested = save_requested or action_of(event) == "save image"
                if action_of(event) == "full screen":
                    window.toggle_full_screen()
            window.begin()
            renderer.draw(face.neutral, POSE, view, window.framebuffer)
            with overlay.frame(window):
                if view.help:
                    draw_help(overlay, help_lines(), (window.size[0] / 2, window.size[1] / 2))
            if save_requested:
                save_image(Path(sys.argv[1]), window.read())
                report(saved=window.size)
                save_requested = False
            window.end()
            for event in events:
                report(event=type(event).__name__, **asdict(event), view=asdict(view))
            if window.size != size:
                size = window.size
                report(size=size)
    report(closed=True)


if __name__ == "__main__":
    main()
