import numpy as np
import pytest

from conf.face.deformation.face_model import FaceModel
from conf.face.head_catalogue import DEFAULT_NUMBER
from conf.protocol.voice.formats import VoiceState
from conf.receiver.frame_composer import FrameComposer
from conf.receiver.voice.call_sound import ClipSound
from conf.receiver.voice.participant_voice import ParticipantVoice
from conf.receiver.voice.voice_mixer import VoiceMixer
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


@pytest.mark.slow
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
    assert (images["m"][60:, :100] != first[60:, :100]).any() and (images["h"][100:140] != first[100:140]).any()


@pytest.mark.slow
def test_the_recording_sign_is_in_the_window_and_not_in_the_recorded_file(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, face: FaceModel
) -> None:
    recorded: list[Pixels] = []
    with FrameComposer(window, face, make_receiver()) as composer:
        controls = composer.controls
        without = composed(composer, window, 0.0)
        monkeypatch.setattr(type(controls), "is_capturing", True)
        monkeypatch.setattr(controls, "recordings", lambda now: [("R", now)])
        monkeypatch.setattr(controls, "on_frame_drawn", lambda now: recorded.append(window.read()))
        shown = composed(composer, window, 0.1)
    corner = np.s_[5:40, 240:]
    assert (shown[corner] != without[corner]).any()
    np.testing.assert_array_equal(recorded[0][corner], without[corner])
    assert (recorded[0] != without).any(), "the line of statistics is not recorded"


@pytest.mark.slow
def test_the_resolution_of_the_heads_follows_the_drawing_time(window: OffscreenWindow, face: FaceModel) -> None:
    """All pixels of the window take 100 ms, then 1 ms."""
    for pixels_s, scale in ((0.1, 0.5), (0.001, 1.0)):
        now, composers = [0.0], list[FrameComposer]()

        def clock(
            pixels_s: float = pixels_s, now: list[float] = now, composers: list[FrameComposer] = composers
        ) -> float:
            now[0] += pixels_s * composers[0]._grid._heads.scale ** 2
            return now[0]

        with FrameComposer(window, face, make_receiver(), draw_clock=clock) as composer:
            composers.append(composer)
            for frame in range(60):
                composed(composer, window, frame / 30)
            target = composer._grid._heads._drawables[DEFAULT_NUMBER].renderer.target
            assert target is not None and target.size == (window.size[0] * scale, window.size[1] * scale)


@pytest.mark.slow
def test_a_paused_image_does_not_change(window: OffscreenWindow, face: FaceModel) -> None:
    endpoint, caller = make_receiver(), SimulatedSender(0.0)
    with FrameComposer(window, face, endpoint) as composer:
        composer.controls.view = ViewState(stats=False, centred=False)
        now = exchange(endpoint, caller, 0.0, 3.0)
        moving = [composed(composer, window, now)]
        now = exchange(endpoint, caller, now, 0.8)
        moving.append(composed(composer, window, now))
        composer.controls.paused = True
        now = exchange(endpoint, caller, now, 0.3)
        moving.append(composed(composer, window, now))
    below = [image[40:] for image in moving]  # the line of statistics
    assert (below[0] != below[1]).any()
    np.testing.assert_array_equal(below[1], below[2])


@pytest.mark.slow
def test_the_name_of_who_speaks_is_highlighted_and_a_microphone_that_is_off_is_beside_its_caller(
    monkeypatch: pytest.MonkeyPatch, window: OffscreenWindow, face: FaceModel
) -> None:
    endpoint, rng = make_receiver(), np.random.default_rng(1)
    callers = [SimulatedSender(0.0, address=(f"10.0.0.{n}", 9)) for n in (1, 2)]
    now = 0.0
    for caller in callers:
        now = exchange(endpoint, caller, now, 1.0)
    mixer = VoiceMixer(endpoint.streams, rng)
    first, second = endpoint.streams
    for session, state in (first, VoiceState.OFF), (second, VoiceState.TALKING):
        mixer.participants[session] = ParticipantVoice(endpoint.streams[session].voice, rng)
        endpoint.streams[session].voice.state = state
    mixer.loudest = second
    labels = set[tuple[str, bool]]()
    monkeypatch.setattr(
        "conf.receiver.call_panels.draw_label", lambda text, corner, highlighted: labels.add((text, highlighted))
    )
    with FrameComposer(window, face, endpoint, sound=ClipSound(mixer)) as composer:
        composer.names.update({first: "Ann", second: "Bob"})
        composed(composer, window, now)
    assert labels == {("Ann  microphone off", False), ("Bob", True)}
