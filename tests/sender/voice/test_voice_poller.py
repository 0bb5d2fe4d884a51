from types import SimpleNamespace

import pytest

from conf.errors import AudioError
from conf.protocol.voice.formats import VoiceState
from conf.sender.voice.voice_poller import VOICE_POLL_S, VoicePoller


class FakeVoice:
    """A voice that may fail. polls : (source time, now)"""

    def __init__(self) -> None:
        self.polls: list[tuple[float, float]] = []
        self.fails = self.closed = False
        self.due_in_s = 0.0

    def poll(self, until: float, outlet: object, now: float) -> None:
        if self.fails:
            raise AudioError("the microphone gives no sound any more")
        self.polls.append((until, now))

    def close(self) -> None:
        self.closed = True


@pytest.fixture
def outlet() -> SimpleNamespace:
    states: list[VoiceState] = []
    return SimpleNamespace(states=states, set_voice_state=lambda state, now: states.append(state))


def test_the_voice_is_polled_every_ten_milliseconds(outlet: SimpleNamespace) -> None:
    voice = FakeVoice()
    poller = VoicePoller(voice)
    for step in range(1000):
        poller.poll(step / 1000, outlet, step / 1000)
    assert len(voice.polls) == pytest.approx(1.0 / VOICE_POLL_S, abs=10)
    assert all(until == now for until, now in voice.polls)


def test_a_loop_waits_no_longer_than_until_the_next_poll(outlet: SimpleNamespace) -> None:
    poller = VoicePoller(FakeVoice())
    assert poller.wait_s(5.0) == 0.0
    poller.poll(5.0, outlet, 5.0)
    assert poller.wait_s(5.0) == pytest.approx(VOICE_POLL_S) and poller.wait_s(5.1) == 0.0
    assert VoicePoller(None).wait_s(5.0) == float("inf")


def test_while_no_packet_can_be_complete_it_is_polled_less_and_then_in_time(outlet: SimpleNamespace) -> None:
    voice, polls = FakeVoice(), []
    poller, now = VoicePoller(voice), 0.0
    while now < 0.6:
        voice.due_in_s = 0.08 - now % 0.08
        poller.poll(now, outlet, now)
        polls.append(now)
        now += max(poller.wait_s(now), 1e-3)
    assert 15 <= len(polls) <= 23
    complete = [0.08 * n for n in range(1, 7)]
    assert all(min(at - due for at in polls if at >= due - 1e-6) <= VOICE_POLL_S + 1e-6 for due in complete)


def test_with_a_frame_it_is_polled_at_once(outlet: SimpleNamespace) -> None:
    voice = FakeVoice()
    poller = VoicePoller(voice)
    poller.poll(0.0, outlet, 5.0)
    poller.poll_now(0.001, outlet, 5.001)
    poller.poll(0.002, outlet, 5.002)
    assert voice.polls == [(0.0, 5.0), (0.001, 5.001)]


def test_before_the_first_frame_and_without_a_voice_nothing_is_polled(outlet: SimpleNamespace) -> None:
    voice = FakeVoice()
    VoicePoller(voice).poll(None, outlet, 0.0)
    VoicePoller(None).poll(0.0, outlet, 0.0)
    assert voice.polls == [] and outlet.states == []


def test_a_microphone_that_fails_is_told_until_it_works_again(outlet: SimpleNamespace) -> None:
    voice = FakeVoice()
    poller = VoicePoller(voice)
    voice.fails = True
    poller.poll(0.0, outlet, 0.0)
    poller.poll(1.0, outlet, 1.0)
    assert outlet.states == [VoiceState.OFF] * 2 and not voice.polls
    assert poller.note == "the microphone gives no sound any more"
    voice.fails = False
    poller.poll(2.0, outlet, 2.0)
    assert poller.note == "" and voice.polls == [(2.0, 2.0)]
