"""The timeline: the player of the recording, and the motion recorder."""

from dataclasses import replace
from pathlib import Path

from imgui_bundle import imgui

from conf.animator.controller import Controller
from conf.animator.gui.widgets import add_tooltip, button, checkbox, highlighted, path_field
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
    field = path_field("DPC file", fields.recording, "Open")
    controller.state = replace(controller.state, fields=replace(fields, recording=field.text))
    if field.browse:
        controller.choose_file("recording")
    if field.confirmed:
        controller.open_file(Path(field.text), now)


def _draw_seek_bar(player: MotionPlayer, now: float) -> None:
    position, duration = player.position(now), player.duration
    imgui.set_next_item_width(-1)
    text = f"%.2f s of {duration:.2f} s    frame {player.frame(now) + 1} of {len(player.clip.displacements)}"
    flags = imgui.SliderFlags_.always_clamp
    changed, position = imgui.slider_float("##seek", position, 0.0, max(duration, 1e-3), text, flags)
    add_tooltip("##seek")
    if changed:
        player.seek(position, now)


def _draw_buttons(controller: Controller, player: MotionPlayer, now: float, scale: float) -> None:
    if button("Pause" if player.is_playing(now) else "Play", BUTTON_PX * scale):
        player.toggle(now)
    imgui.same_line()
    if button("Stop", BUTTON_PX * scale):
        player.stop(now)
    for text, frames in (("<", -1), (">", 1)):
        imgui.same_line()
        if button(text, STEP_BUTTON_PX * scale):
            player.step(frames, player.clip.fps, now)
    imgui.same_line()
    imgui.set_next_item_width(SPEED_PX * scale)
    flags = imgui.SliderFlags_.logarithmic | imgui.SliderFlags_.always_clamp
    changed, speed = imgui.slider_float("##speed", player.speed, *SPEEDS, "speed %.2fx", flags)
    add_tooltip("##speed")
    if changed:
        player.set_speed(1.0 if abs(speed - 1) < SPEED_SNAP else speed, now)
    imgui.same_line()
    player.loop = checkbox("loop", player.loop)
    imgui.same_line()
    _draw_record_button(controller, now)
    imgui.same_line()
    if button("Close"):
        controller.player = None
    imgui.same_line()
    imgui.text_colored(imgui.ImVec4(*MUTED), player.name)


def _draw_record_button(controller: Controller, now: float) -> None:
    recording = controller.recorder is not None
    with highlighted(recording):
        if button("Stop recording" if recording else "Record motion"):
            controller.toggle_recorder(now)
