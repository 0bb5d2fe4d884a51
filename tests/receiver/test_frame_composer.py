import numpy as np
import pytest

from conf.face.deformation.face_model import FaceModel
from conf.receiver.frame_composer import FrameComposer
from conf.render.camera import ViewState
from conf.render.window.input_events import Event, KeyPressed
from conf.render.window.offscreen import OffscreenWindow
from tests.support.image_measures import Pixels
from tests.support.simulated_calls import SimulatedSender, exchange, make_receiver


def composed(composer: FrameComposer, window: OffscreenWindow, now: float) -> Pixels:
    composer.draw(now)
    pixels = window.read()
    composer.present(now)
    return pixels


def test_keys_switch_the_panels_over_the_image(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, face: FaceModel
) -> None:
    def press(key: str) -> None:
        events: list[Event] = [KeyPressed(key)]
        monkeypatch.setattr(window, "poll", lambda: [events.pop()] if events else [])

    with FrameComposer(window, face, make_receiver(), idle_text="listening") as composer:
        first = composed(composer, window, 0.0)
        images = {}
        for key in "mh":
            press(key)
            images[key] = composed(composer, window, 0.1)
            press(key)
            composed(composer, window, 0.2)
    assert (images["m"][:, :100] != first[:, :100]).any() and (images["h"][100:140] != first[100:140]).any()


@pytest.mark.slow
def test_a_paused_image_does_not_change(window: OffscreenWindow, face: FaceModel) -> None:
    endpoint, caller = make_receiver(), SimulatedSender(0.0)
    with FrameComposer(window, face, endpoint) as composer:
        composer.controls.view = ViewState(stats=False, centred=False)
        now = exchange(endpoint, caller, 0.0, 3.0)
        moving = [composed(composer, window, now)]
        now = exchange(endpoint, caller, now, 0.3)
        moving.append(composed(composer, window, now))
        composer.controls.paused = True
        now = exchange(endpoint, caller, now, 0.3)
        moving.append(composed(composer, window, now))
    assert (moving[0] != moving[1]).any()
    np.testing.assert_array_equal(moving[1], moving[2])
