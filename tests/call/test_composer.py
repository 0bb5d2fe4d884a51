"""Frames of a simulated call: two endpoints in memory, one of them drawn."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from conf.call.composer import CallComposer
from conf.call.controls import LocalState
from conf.call.screen import CallScreen
from conf.call.self_view import SelfView
from conf.call.view import Waiting
from conf.face.deformation.face_model import FaceModel
from conf.protocol.call_endpoint import CallEndpoint
from conf.protocol.messages import MotionFrame
from conf.receiver.participant_grid import BACKGROUND
from conf.receiver.voice.call_sound import ClipSound
from conf.receiver.voice.voice_mixer import VoiceMixer
from conf.render.window.input_events import Event, KeyPressed, MouseButton
from conf.render.window.offscreen import OffscreenWindow
from conf.sender.capture.frame import Frame
from tests.support.simulated_call import A, B, Link
from tests.support.simulated_calls import PARAMETERS, talk
from tests.support.simulated_sessions import CODE, seeded

pytestmark = pytest.mark.slow

SIZE = (640, 480)
WAITING = Waiting("192.0.2.1:5005", CODE)


class Stage:
    """Ann's window; Bob calls her. screens : what was shown, frame by frame; images : the same as pixels"""

    def __init__(self, window: OffscreenWindow, face: FaceModel, patch: pytest.MonkeyPatch, **options: Any) -> None:
        self.ann, self.bob = (
            CallEndpoint(code=CODE, parameters=PARAMETERS, now=1000.0, random=seeded(name), remote=remote, name=name)
            for name, remote in (("Ann", None), ("Bob", A))
        )
        self.link: Link[CallEndpoint] = Link({A: self.ann})
        self.window = window
        self.state, self.view = LocalState(), SelfView()
        self.events: list[Event] = []
        self.screens: list[CallScreen] = []
        self.has_face = True
        patch.setattr(window, "poll", self._poll)
        self.composer = CallComposer(
            window, face, self.ann, self.state, self.view, waiting=WAITING, has_face=lambda: self.has_face, **options
        )
        build = self.composer._screen
        patch.setattr(self.composer, "_screen", lambda *given: self.screens.append(build(*given)) or self.screens[-1])  # type: ignore[func-returns-value]

    def _poll(self) -> list[Event]:
        events, self.events = self.events, []
        return events

    def connect(self) -> None:
        self.link.ends[B] = self.bob
        self.link.tick = lambda now: self.bob.send_frame(talk(now), now)
        self.run(2.0)

    def run(self, seconds: float) -> None:
        self.link.run(seconds)
        self.draw()

    def draw(self, *events: Event) -> Any:
        """Draw a frame and return it, (H, W, 3)."""
        self.events = list(events)
        self.composer.draw(self.link.now)
        image = self.window.read()
        self.composer.present(self.link.now)
        return image

    @property
    def screen(self) -> CallScreen:
        return self.screens[-1]


@pytest.fixture
def stage(gl: None, face: FaceModel, monkeypatch: pytest.MonkeyPatch) -> Any:
    with OffscreenWindow(*SIZE) as window:
        stage = Stage(window, face, monkeypatch)
        yield stage
        stage.composer.controls.close()
        stage.composer.release()


def words(screen: CallScreen) -> str:
    return " | ".join([part.text for part in screen.status] + [screen.name, screen.own_caption, *screen.messages])


def green(image: Any) -> int:
    """Return the number of pixels in the colour of the simulated camera."""
    return int((image == (0, 255, 0)).all(axis=2).sum())


def test_while_one_waits_the_code_is_shown_and_no_head(stage: Stage) -> None:
    image = stage.draw()
    assert stage.screen.notice and stage.screen.notice.large == CODE and not stage.composer.shows_somebody
    background = tuple(round(channel * 255) for channel in reversed(BACKGROUND))
    assert np.abs(image[60, 20].astype(int) - background).max() <= 1
    assert stage.screen.buttons[-1].text == "leave" and stage.screen.own_aspect is None


def test_in_a_call_the_other_is_drawn_and_named(stage: Stage) -> None:
    stage.connect()
    waiting = stage.draw()
    stage.run(1.0)
    assert stage.composer.shows_somebody and stage.screen.notice is None
    assert (waiting != stage.draw()).any()
    assert words(stage.screen).startswith("good | Bob | 0:00 | ") and stage.screen.name.startswith("Bob")
    assert stage.screen.buttons[-1].text == "hang up"


def test_the_camera_of_the_other_and_silence_are_said(stage: Stage) -> None:
    stage.connect()
    stage.link.tick = stage.bob.send_camera_off
    stage.run(2.0)
    assert (stage.screen.name, stage.screen.name_note) == ("Bob", "camera off")
    stage.link.unreachable.add(A)
    stage.run(5.0)
    assert words(stage.screen).startswith("lost: no reply for 6 s")


def test_the_other_has_no_microphone_only_if_nothing_of_a_voice_comes_for_two_seconds(
    gl: None, face: FaceModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    sound = ClipSound(VoiceMixer({}, np.random.default_rng(1)))
    with OffscreenWindow(*SIZE) as window:
        stage = Stage(window, face, monkeypatch, sound=sound)
        stage.connect()
        assert (stage.screen.name, stage.screen.name_note) == ("Bob", "")
        stage.run(2.0)
        assert (stage.screen.name, stage.screen.name_note) == ("Bob", "no microphone")
        stage.composer.controls.close()
        stage.composer.release()


def test_after_the_call_the_code_is_shown_again_with_what_happened(stage: Stage) -> None:
    stage.connect()
    stage.link.tick = lambda now: None
    for data, target in stage.bob.close(stage.link.now):
        stage.link.put(data, B, target)
    del stage.link.ends[B]
    stage.link.run(0.5)
    stage.composer.report("Bob has hung up", stage.link.now)
    stage.draw()
    assert stage.screen.notice and stage.screen.notice.lines[0] == "Bob has hung up"
    assert stage.screen.messages == [] and not stage.composer.shows_somebody


def test_one_s_own_image_and_state_are_shown(stage: Stage) -> None:
    stage.connect()
    stage.view.show(Frame(np.full((48, 64, 3), (0, 255, 0), np.uint8), 0.0), None)
    image = stage.draw()
    assert green(image) > 4000 and stage.screen.own_caption == "you"
    stage.has_face = False
    stage.draw(KeyPressed("m"))
    assert stage.screen.own_caption == "you  no face seen  muted" and not stage.state.microphone
    stage.view.clear()
    stage.draw(KeyPressed("c"))
    assert stage.screen.own_caption == "you  camera off  muted" and not stage.state.camera
    assert stage.screen.own_aspect is not None


def test_o_shows_what_the_other_sees(stage: Stage) -> None:
    stage.connect()
    stage.view.show(Frame(np.full((48, 64, 3), (0, 255, 0), np.uint8), 0.0), None)
    camera = stage.draw()
    stage.view.sent = MotionFrame(1.0, np.zeros((50, 3), np.float32), np.array([0, 0, 0, 0, 0, -3.5]))
    seen = stage.draw(KeyPressed("o"))
    assert stage.screen.own_caption == "what is seen of you"
    assert green(camera) > 4000 and green(seen) == 0
    assert green(stage.draw(KeyPressed("o"))) > 4000


def test_a_button_is_clicked_where_it_is_drawn(stage: Stage) -> None:
    stage.connect()
    stage.draw()
    rect = next(button.rect for button in stage.composer._own.buttons if button.action == "camera")
    stage.draw(MouseButton(0, True, rect.left + 3, rect.top + 3))
    assert not stage.state.camera and stage.screen.buttons[1].is_warning


def test_a_saved_image_has_no_buttons(stage: Stage, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    stage.connect()
    shown = stage.draw(KeyPressed("s"))
    (saved,) = tmp_path.glob("*.jpg")
    image = cv2.imread(str(saved))
    assert image is not None and image.shape == shown.shape
    rect = stage.composer._own.buttons[-1].rect
    button = np.s_[round(rect.top) + 2 : round(rect.bottom) - 2, round(rect.left) + 2 : round(rect.right) - 2]
    assert np.abs(image[button].astype(int) - shown[button]).mean() > 20


def test_a_clip_that_is_written_shows_neither_buttons_nor_oneself(
    gl: None, face: FaceModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    with OffscreenWindow(*SIZE) as window:
        stage = Stage(window, face, monkeypatch, is_interactive=False)
        stage.view.show(Frame(np.zeros((48, 64, 3), np.uint8), 0.0), None)
        stage.draw()
        assert not stage.screen.buttons and stage.screen.own_aspect is None
        stage.composer.release()


def test_who_calls_next_has_neither_the_name_nor_the_photo_of_who_called_before(stage: Stage) -> None:
    stage.connect()
    first = next(iter(stage.ann.streams.values()))
    first.received_objects.append(b"an object")
    stage.draw()
    assert 0 in stage.composer._grid._portraits and stage.screen.name.startswith("Bob")
    stage.link.tick = lambda now: None
    for data, target in stage.bob.close(stage.link.now):
        stage.link.put(data, B, target)
    del stage.link.ends[B]
    stage.link.run(0.5)
    eve = CallEndpoint(code=CODE, parameters=PARAMETERS, now=stage.link.now, random=seeded("Eve"), remote=A, name="Eve")
    stage.link.ends[B] = eve  # between two frames, as on a slow machine
    stage.link.run(2.0)
    assert stage.ann.streams and next(iter(stage.ann.streams.values())) is not first
    stage.draw()
    assert 0 not in stage.composer._grid._portraits and stage.screen.name.startswith("Eve")


def test_who_calls_is_not_said_to_wait(gl: None, face: FaceModel, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.call.test_composer.WAITING", Waiting("192.0.2.1:5005"))
    with OffscreenWindow(*SIZE) as window:
        stage = Stage(window, face, monkeypatch)
        stage.draw()
        assert words(stage.screen).startswith("calling | ") and stage.screen.notice
        stage.composer.release()
