"""A program with a window, for test_window: draws a stand-in face, reports each event as a line of JSON.

python -m tests.support.window_process PICTURE.png
"""

import json
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np

from conf.face.deformation.face_model import FaceModel
from conf.face.fapu import Fapu
from conf.face.head_pose import HeadPose
from conf.output.media_writer import save_picture
from conf.receiver.hud import draw_help
from conf.render.camera import ViewState
from conf.render.face_renderer import FaceRenderer
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window.glfw_window import GlfwWindow
from conf.render.window.input_events import action_of, apply_camera_event
from tests.support.stand_in_head import control_points, stand_in_mesh

POSE = HeadPose(np.zeros(3), np.zeros(2), float(np.log(0.03)))


def say(**facts: object) -> None:
    """Write one line for the test to read."""
    sys.stdout.write(json.dumps(facts) + "\n")
    sys.stdout.flush()


def main() -> None:
    """Draw until Q is pressed; S saves the picture."""
    mesh, points = stand_in_mesh(), control_points()
    face = FaceModel(mesh, points, Fapu.measure(points), np.zeros((len(mesh.vertices), 50), np.float32))
    view, wanted = ViewState(), False
    with GlfwWindow(320, 240, "conf test") as window:
        renderer, overlay = FaceRenderer(window.ctx, face), ImGuiOverlay(window.ctx)
        started = False
        while not window.should_close:
            events = window.poll()
            for event in events:
                view = apply_camera_event(view, event)
                wanted = wanted or action_of(event) == "picture"
                if action_of(event) == "full screen":
                    window.toggle_full_screen()
            window.begin()
            renderer.draw(face.neutral, POSE, view, window.framebuffer)
            with overlay.frame(window.framebuffer, window.size, window.pixel_ratio):
                if view.help:
                    draw_help(overlay)
            if wanted:
                save_picture(Path(sys.argv[1]), window.read())
                say(saved=window.size)
                wanted = False
            window.end()
            if not started:
                say(ready=window.size)
                started = True
            for event in events:
                say(event=type(event).__name__, **asdict(event), view=asdict(view))
        overlay.release()
        renderer.release()
    say(closed=True)


if __name__ == "__main__":
    main()
