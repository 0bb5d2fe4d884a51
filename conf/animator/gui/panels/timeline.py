"""The timeline: the player of the recording, and the motion recorder."""

from dataclasses import replace
from pathlib import Path

from imgui_bundle import imgui

from conf.animator.controller import Controller
from conf.animator.gui.widgets import highlighted, path_field
from conf.animator.motion_player import MotionPlayer
from conf.face.animation.playback import SPEEDS
from conf.render.ui.imgui_overlay import MUTED

# Widths in pixels at scale 1.
BUTTON_PX = 58.0
STEP_BUTTON_PX = 30.0
SPEED_PX = 120.0
SPEED_SNAP = 0.04  # a speed nearer than this to 1 becomes 1


def draw_timeline(controller: Controller, now: float, scale: float) -> None:
    if controller.player is not None:
        _draw_seek_bar(controller.player, now)
        _draw_buttons(controller, controller.player, now, scale)
        return
    imgui.align_text_to_frame_padding()
    imgui.text_colored(imgui.ImVec4(*MUTED), "No recording. Open a DPC file (conf extract writes them), or")
    imgui.same_line()
    _draw_record_button(controller, now)
    fields = controller.state.fields
    path, confirmed = path_field("DPC file", fields.recording, "Open")
    controller.state = replace(controller.state, fields=replace(fields, recording=path))
    if confirmed:
        controller.open_file(Path(path), now)


def _draw_seek_bar(player: MotionPlayer, now: float) -> None:
    position, duration = player.position(now), player.duration
    imgui.set_next_item_width(-1)
    text = f"%.2f s of {duration:.2f} s    frame {player.frame(now) + 1} of {len(player.clip.displacements)}"
    flags = imgui.SliderFlags_.always_clamp
    changed, position = imgui.slider_float("##seek", position, 0.0, max(duration, 1e-3), text, flags)
    if changed:
        player.seek(position, now)


def _draw_buttons(controller: Controller, player: MotionPlayer, now: float, scale: float) -> None:
    button, step_button = imgui.ImVec2(BUTTON_PX * scale, 0), imgui.ImVec2(STEP_BUTTON_PX * scale, 0)
    if imgui.button("Pause" if player.is_playing(now) else "Play", button):
        player.toggle(now)
    imgui.same_line()
    if imgui.button("Stop", button):
        player.stop(now)
    for text, frames in (("<", -1), (">", 1)):
        imgui.same_line()
        if imgui.button(text, step_button):
            player.step(frames, player.clip.fps, now)
    imgui.same_line()
    imgui.set_next_item_width(SPEED_PX * scale)
    flags = imgui.SliderFlags_.logarithmic | imgui.SliderFlags_.always_clamp
    changed, speed = imgui.slider_float("##speed", player.speed, *SPEEDS, "speed %.2fx", flags)
    if changed:
        player.set_speed(1.0 if abs(speed - 1) < SPEED_SNAP else speed, now)
    imgui.same_line()
    player.loop = imgui.checkbox("loop", player.loop)[1]
    imgui.same_line()
    _draw_record_button(controller, now)
    imgui.same_line()
    if imgui.button("Close"):
        controller.player = None
    imgui.same_line()
    imgui.text_colored(imgui.ImVec4(*MUTED), player.name)


def _draw_record_button(controller: Controller, now: float) -> None:
    recording = controller.recorder is not None
    with highlighted(recording):
        if imgui.button("Stop recording" if recording else "Record motion"):
            controller.toggle_recorder(now)
