"""The question before control points placed by hand are lost: by quitting, or by cancelling the placement."""

from dataclasses import replace

from imgui_bundle import imgui

from conf.animator.controller import Controller
from conf.animator.gui.widgets import buttons
from conf.animator.keys import key_label
from conf.render.ui.wrapped_text import hint

WIDTH_PX = 330.0  # at scale 1
SAVE, DISCARD, KEEP = "Save and quit", "Quit without saving", "Do not quit"
DISCARD_POINTS, KEEP_POINTS = "Discard the points", "Go on placing"
_TITLE = "unsaved control points"
_FLAGS = (
    imgui.WindowFlags_.always_auto_resize
    | imgui.WindowFlags_.no_title_bar
    | imgui.WindowFlags_.no_move
    | imgui.WindowFlags_.no_saved_settings
)


def draw_question(controller: Controller, centre: tuple[float, float], scale: float) -> bool:
    """Draw the open question centred at these pixels. Returns whether the user decided to quit."""
    question = controller.state.question
    if question is None:
        return False
    if not imgui.is_popup_open(_TITLE):
        imgui.open_popup(_TITLE)
    imgui.set_next_window_pos(imgui.ImVec2(*centre), imgui.Cond_.always, imgui.ImVec2(0.5, 0.5))
    imgui.set_next_window_size(imgui.ImVec2(WIDTH_PX * scale, 0))
    decided = False
    if imgui.begin_popup_modal(_TITLE, None, _FLAGS)[0]:
        decided = _draw_quit(controller) if question == "quit" else _draw_cancel(controller)
        if controller.state.question is None or decided:
            imgui.close_current_popup()
        imgui.end_popup()
    return decided


def _draw_quit(controller: Controller) -> bool:
    placement = controller.state.placement
    imgui.text_wrapped("Quit? The control points that you placed are not saved.")
    is_complete = placement is None or not placement.missing
    if is_complete:
        hint(f"They would be saved as {controller.points_path.absolute()}.")
    elif placement is not None:
        hint(f"A PPC file needs all points: {placement.missing} are missing.")
    hint(f"{key_label('quit')} again quits without saving, {key_label('back')} goes back.")
    pressed = buttons((*([SAVE] if is_complete else []), DISCARD, KEEP), 1)
    if pressed == SAVE:
        return controller.save_for_quit()
    if pressed == KEEP:
        controller.state = replace(controller.state, question=None)
    return pressed == DISCARD


def _draw_cancel(controller: Controller) -> bool:
    imgui.text_wrapped("Stop placing? The control points that you placed or moved are lost.")
    pressed = buttons((DISCARD_POINTS, KEEP_POINTS), 1)
    if pressed == DISCARD_POINTS:
        controller.cancel_placement(confirmed=True)
    elif pressed == KEEP_POINTS:
        controller.state = replace(controller.state, question=None)
    return False
