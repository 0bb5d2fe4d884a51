"""The time line: the recording's player."""

from dataclasses import replace
from pathlib import Path

from imgui_bundle import imgui

from conf.animator.commands import (
    CloseRecording,
    OpenFile,
    Request,
    Seek,
    SetLoop,
    SetSpeed,
    StepFrames,
    Stop,
    ToggleMotionRecording,
    TogglePlaying,
)
from conf.animator.gui.widgets import highlighted, path_field
from conf.animator.motion_player import MotionPlayer
from conf.animator.state.editor import EditorState, StatusInfo
from conf.face.animation.playback import SPEEDS
from conf.render.ui.imgui_overlay import MUTED

BUTTON = 58.0  # pixels at scale 1
NARROW = 30.0


def draw_timeline(desk: EditorState, facts: StatusInfo, scale: float) -> tuple[EditorState, list[Request]]:
    """Draw the panel."""
    requests: list[Request] = []
    recording = desk.fields.recording
    if facts.player is None:
        imgui.align_text_to_frame_padding()
        imgui.text_colored(imgui.ImVec4(*MUTED), "No recording. Open a DPC file (conf extract makes them), or")
        imgui.same_line()
        _take_button(facts, requests)
        recording, go = path_field("DPC file", recording, "Open")
        if go:
            requests.append(OpenFile(Path(recording)))
    else:
        _draw_seek_bar(facts.player, facts.now, requests)
        _draw_buttons(facts, facts.player, scale, requests)
    return replace(desk, fields=replace(desk.fields, recording=recording)), requests


def _draw_seek_bar(player: MotionPlayer, now: float, requests: list[Request]) -> None:
    position, duration = player.clock.position(now), player.recording.duration
    imgui.set_next_item_width(-1)
    frames = len(player.recording.motion.displacements)
    form = f"%.2f s of {duration:.2f} s    frame {player.frame(now) + 1} of {frames}"
    moved, place = imgui.slider_float(
        "##seek", position, 0.0, max(duration, 1e-3), form, imgui.SliderFlags_.always_clamp
    )
    if moved:
        requests.append(Seek(place))


def _draw_buttons(facts: StatusInfo, player: MotionPlayer, scale: float, requests: list[Request]) -> None:
    playing = player.clock.is_playing(facts.now)
    row: tuple[tuple[str, float, Request], ...] = (
        ("Pause" if playing else "Play", BUTTON, TogglePlaying()),
        ("Stop", BUTTON, Stop()),
        ("<", NARROW, StepFrames(-1)),
        (">", NARROW, StepFrames(1)),
    )
    for text, width, request in row:
        if imgui.button(text, imgui.ImVec2(width * scale, 0)):
            requests.append(request)
        imgui.same_line()
    imgui.set_next_item_width(120 * scale)
    flags = imgui.SliderFlags_.logarithmic | imgui.SliderFlags_.always_clamp
    moved, speed = imgui.slider_float("##speed", player.clock.speed, *SPEEDS, "speed %.2fx", flags)
    if moved:
        requests.append(SetSpeed(1.0 if abs(speed - 1) < 0.04 else speed))
    imgui.same_line()
    ticked, loop = imgui.checkbox("loop", player.clock.loop)
    if ticked:
        requests.append(SetLoop(loop))
    imgui.same_line()
    _take_button(facts, requests)
    imgui.same_line()
    if imgui.button("Close"):
        requests.append(CloseRecording())
    imgui.same_line()
    imgui.text_colored(imgui.ImVec4(*MUTED), player.recording.name)


def _take_button(facts: StatusInfo, requests: list[Request]) -> None:
    with highlighted(facts.recording):
        if imgui.button("End the take" if facts.recording else "Record a take"):
            requests.append(ToggleMotionRecording())
