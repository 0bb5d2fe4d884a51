from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from conf.receiver.call_display import HIDDEN_STEP_S, CallDisplay, LoopOptions


class FakeComposer:
    """Records what is drawn and shown."""

    def __init__(self) -> None:
        self.log: list[Any] = []
        self.toasts: list[str] = []
        self.note = ""
        self.controls = SimpleNamespace(
            quit_requested=False,
            reports=["saved conf.jpg"],
            show_toast=self.report,
            close=lambda: self.log.append("close"),
        )

    def report(self, text: str, now: float) -> None:
        self.toasts.append(text)

    def draw(self, now: float) -> None:
        self.log.append(("draw", now))

    def present(self, now: float) -> None:
        self.log.append(("present", now))

    def release(self) -> None:
        self.log.append("release")


class Stage:
    """A display of a fake composer. events : lines for the terminal"""

    def __init__(self) -> None:
        self.composer, self.events = FakeComposer(), list[str]()
        self.window = SimpleNamespace(should_close=False, visible=True)
        self.options = LoopOptions(10.0, on_event=self.events.append)
        self.display = CallDisplay(self.window, self.composer, self.options)  # type: ignore[arg-type]


def test_a_frame_is_drawn_handed_over_and_presented_in_this_order() -> None:
    stage = Stage()
    stage.options = replace(stage.options, on_frame=lambda window, now: stage.composer.log.append("on frame"))
    stage.display = CallDisplay(stage.window, stage.composer, stage.options)  # type: ignore[arg-type]
    assert stage.display.step(1.0) == 1.0
    assert stage.composer.log == [("draw", 1.0), "on frame", ("present", 1.0)]
    assert stage.display.step(1.01) == pytest.approx(1.1)
    assert len(stage.composer.log) == 3
    stage.display.close()
    assert stage.composer.log[3:] == ["close", "release"]


def test_nothing_is_drawn_before_the_window_is_shown() -> None:
    stage = Stage()
    stage.window.visible = False
    assert stage.display.step(1.0) == 1.0 + HIDDEN_STEP_S and stage.composer.log == []
    stage.display.show()
    assert stage.window.visible
    stage.display.step(1.1)
    assert stage.composer.log == [("draw", 1.1), ("present", 1.1)]


def test_a_window_is_hidden_at_the_end() -> None:
    window = SimpleNamespace(visible=True)
    CallDisplay(window, FakeComposer(), LoopOptions(30.0)).hide()  # type: ignore[arg-type]
    assert not window.visible


def test_a_text_is_shown_and_printed() -> None:
    stage = Stage()
    stage.display.report("a call from Ann", 0.0)
    stage.display.show_toast("only here", 0.0)
    assert stage.composer.toasts == ["a call from Ann", "only here"] and stage.events == ["a call from Ann"]
    assert stage.display.reports == ["saved conf.jpg"]


def test_the_start_and_the_end_of_a_fault_are_printed_once() -> None:
    stage = Stage()
    for note in ("", "nothing can be sent (trying for 10 s more)", "nothing can be sent (trying for 9 s more)", ""):
        stage.display.show_faults(note, 0.0, in_call=True)
    assert stage.events == ["nothing can be sent (trying for 10 s more)", "it works again"]
    stage.display.show_faults("again", 0.0, in_call=False)
    assert stage.composer.note == "again"
    stage.display.show_faults("", 0.0, in_call=False)
    assert stage.events[2:] == ["again"] and stage.composer.note == ""


def test_a_camera_that_fails_is_printed_once_and_its_return_is_not_the_network_s() -> None:
    stage = Stage()
    for local in ("", "camera 0 gives no images (5 s more)", "camera 0 gives no images (4 s more)", ""):
        stage.display.show_faults("", 0.0, in_call=True, local=local)
    assert stage.events == ["camera 0 gives no images (5 s more)"] and stage.composer.note == ""
    stage.display.show_faults("nothing can be sent", 0.0, in_call=True, local="camera 0 gives no images")
    assert stage.composer.note == "nothing can be sent"


def test_it_is_over_when_the_viewer_quits_or_closes_the_window() -> None:
    stage = Stage()
    assert not stage.display.is_over
    stage.window.should_close = True
    assert stage.display.is_over
    stage.window.should_close, stage.composer.controls.quit_requested = False, True
    assert stage.display.is_over
