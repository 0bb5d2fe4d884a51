"""Right column: the camera's picture, the devices, what others get."""

from imgui_bundle import imgui

from conf.face.head_catalogue import HEADS, HEADS_BY_NAME
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.start.controller import StartController
from conf.start.devices.choices import Choice, DeviceLists, camera_choices, sound_choices, sound_setting
from conf.start.devices.microphone_meter import MicrophoneMeter
from conf.start.devices.speaker_test import SpeakerTest
from conf.start.gui.picture import ASPECT, CameraPicture
from conf.start.gui.widgets import button, checkbox, combo_box, draw_error, heading, level_bar, next_column, text_field

ROWS_BELOW = 11.6  # height of the controls below the picture, in rows
MIN_PICTURE_HEIGHT = 0.25  # of the column
RATES_KBPS = (2.4, 4.8, 6.0, 9.6, 16.0, 32.0)  # those of the voice's rows, and one for images
ERROR_LINES = 2
SEARCHING = "searching ..."
PORTRAIT = "send photos of my face"


def draw_device_panel(controller: StartController, overlay: ImGuiOverlay, picture: CameraPicture) -> None:
    """Draw the column."""
    width, available = imgui.get_content_region_avail()
    height = max(available - ROWS_BELOW * imgui.get_frame_height_with_spacing(), MIN_PICTURE_HEIGHT * available)
    picture.draw(overlay, controller.camera, (width, min(height, width / ASPECT)))
    devices = controller.devices or DeviceLists()
    _draw_camera(controller, devices)
    _draw_microphone(controller, devices)
    _draw_speaker(controller, devices)
    _draw_errors(controller)
    heading("What the other one gets")
    _draw_identity(controller)


def rate_choices(setting: float | None, /) -> list[Choice]:
    """Return the rows of the list of rates."""
    rates = sorted({*RATES_KBPS, *([] if setting is None else [setting])})
    return [Choice("no limit", None), *(Choice(f"{rate:.10g} kbit/s", str(rate)) for rate in rates)]


def head_choices() -> list[Choice]:
    """Return the rows of the list of heads."""
    return [Choice("a free one", None), *(Choice(f"{head.name}: {head.about}", head.name) for head in HEADS)]


def _draw_camera(controller: StartController, devices: DeviceLists) -> None:
    setting = controller.settings.camera
    controller.set_setting("camera", combo_box("camera", camera_choices(devices.cameras, setting), setting))


def _draw_microphone(controller: StartController, devices: DeviceLists) -> None:
    setting = sound_setting(devices.microphones, controller.settings.microphone)
    chosen = combo_box("microphone", sound_choices(devices.microphones, setting), setting)
    if chosen != setting:
        controller.set_setting("microphone", chosen)
    _draw_level(controller.microphone)


def _draw_speaker(controller: StartController, devices: DeviceLists) -> None:
    setting = sound_setting(devices.speakers, controller.settings.speaker)
    chosen = combo_box("speaker", sound_choices(devices.speakers, setting), setting)
    if chosen != setting:
        controller.set_setting("speaker", chosen)
    _draw_level(controller.speaker_test)
    imgui.dummy(imgui.ImVec2(0, 0))
    next_column()
    if button("Test tone"):
        controller.test_speaker()
    imgui.same_line()
    imgui.begin_disabled(controller.devices is None)
    text = "Search again" if controller.devices is not None else SEARCHING
    if button(f"{text}###search"):
        controller.find_devices()
    imgui.end_disabled()


def _draw_level(device: MicrophoneMeter | SpeakerTest | None) -> None:
    imgui.dummy(imgui.ImVec2(0, 0))
    next_column()
    level_bar(device.level if device is not None and not device.error else 0.0)


def _draw_errors(controller: StartController) -> None:
    """Draw what is wrong with the sound, in a part of the panel that is kept free for it: nothing moves."""
    top = imgui.get_cursor_pos_y()
    devices = (controller.microphone, controller.speaker_test)
    errors = [device.error for device in devices if device is not None and device.error]
    for error in errors:
        draw_error(error, lines=ERROR_LINES // len(errors))
    bottom = top + ERROR_LINES * imgui.get_text_line_height_with_spacing()
    imgui.dummy(imgui.ImVec2(0, max(0.0, bottom - imgui.get_cursor_pos_y())))


def _draw_identity(controller: StartController) -> None:
    state, settings = controller.state, controller.settings
    typed = text_field("name", state.name, error=state.name_error)
    controller.state = controller.state.with_field("name", typed.text)
    if typed.entered or typed.left:
        controller.enter_name()
    head = settings.head if settings.head in HEADS_BY_NAME else None
    chosen_head = combo_box("head", head_choices(), head)
    if chosen_head != head:
        controller.set_setting("head", chosen_head)
    portrait = checkbox("portrait", PORTRAIT, bool(settings.portrait))
    if portrait != bool(settings.portrait):
        controller.set_setting("portrait", portrait or None)
    setting = None if settings.kbps is None else str(settings.kbps)
    chosen = combo_box("link rate", rate_choices(settings.kbps), setting)
    controller.set_setting("kbps", None if chosen is None else float(chosen))
