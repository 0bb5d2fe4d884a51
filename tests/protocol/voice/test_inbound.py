from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.messages import VoiceFormatMessage, VoicePayload, VoiceStateMessage
from conf.protocol.stream_clocks import CLOCK_RESET_S, MARGIN_S
from conf.protocol.voice.formats import VoiceFormat, VoicePacket, VoiceState
from conf.protocol.voice.inbound import MAX_FRAMES, MAX_GAP_MS, InboundVoice
from conf.protocol.voice.outbound import OutboundVoice
from conf.protocol.wire import decode_body

OPUS = VoiceFormat("opus", 9000, 60, 1, fixed_size=False)
TWICE = VoiceFormat("opus", 5000, 60, 1, fixed_size=False, repeated=1)
CODEC2 = VoiceFormat("codec2", 1200, 40, 5, fixed_size=True, repeated=5)
WAY_S = 0.04


def name(index: int, voice_format: VoiceFormat = OPUS) -> bytes:
    """Return a frame that says which one it is."""
    return index.to_bytes(6 if voice_format.fixed_size else 2)


class Link:
    """Outgoing and incoming voice joined by a link that loses the packets it is told to."""

    def __init__(self, voice_format: VoiceFormat = OPUS) -> None:
        self.format = voice_format
        self.outbound, self.inbound = OutboundVoice(), InboundVoice()
        self.counter = 0
        self.played: list[tuple[float, bytes | None]] = []

    def talk(self, begin: int, end: int, *, lost: set[int] = frozenset()) -> None:  # type: ignore[assignment]
        """Send the packets begin .. end - 1 of the format, and play until the arrival of each."""
        for index in range(begin, end):
            stamp = index * self.format.packet_s
            frames = tuple(name(index * self.format.frames + i, self.format) for i in range(self.format.frames))
            self.outbound.send(VoicePacket(stamp, self.format, frames))
            self.deliver(stamp + self.format.packet_s + WAY_S, is_lost=index in lost)

    def silence(self, now: float, *, is_lost: bool = False) -> None:
        self.outbound.set_state(VoiceState.SILENT, 60, now)
        for outgoing in self.outbound.state_bodies(now, alone=False):
            self._receive(outgoing.body, now + WAY_S, is_lost=is_lost)
        self.counter += 1
        self.play(now + WAY_S)

    def deliver(self, now: float, *, is_lost: bool = False) -> None:
        for outgoing in self.outbound.drain():
            self._receive(outgoing.body, now, is_lost=is_lost)
        self.counter += 1
        self.play(now)

    def play(self, now: float) -> None:
        frames = self.inbound.frames_until(self.inbound.clock.playhead(now))
        self.played += [(frame.timestamp, frame.data) for frame in frames]

    def _receive(self, data: bytes, now: float, *, is_lost: bool) -> None:
        body = decode_body(data)
        if is_lost:
            return
        match body:
            case VoiceFormatMessage():
                self.inbound.receive_format(body)
            case VoiceStateMessage():
                self.inbound.receive_state(body, self.counter)
            case VoicePayload():
                self.inbound.receive_voice(body, self.counter, now)

    @property
    def heard(self) -> list[bytes | None]:
        return [data for _, data in self.played]


def expected(begin: int, end: int, lost: set[int] = frozenset()) -> list[bytes | None]:  # type: ignore[assignment]
    return [None if index in lost else name(index) for index in range(begin, end)]


def test_frames_come_once_in_order_at_their_times() -> None:
    link = Link()
    link.talk(0, 20)
    link.play(20 * 0.06 + WAY_S + MARGIN_S + 0.01)
    assert link.heard == expected(0, 20)
    assert [time for time, _ in link.played] == pytest.approx([0.06 * i for i in range(20)])
    assert (link.inbound.format, link.inbound.state, link.inbound.lost_ms) == (OPUS, VoiceState.TALKING, 0)
    assert link.inbound.frames_until(1e9)[0].data is None, "nobody said that the talk has ended"


def test_a_frame_is_due_when_the_playhead_has_reached_its_start() -> None:
    link = Link()
    link.outbound.send(VoicePacket(0.0, OPUS, (b"a",)))
    link.deliver(0.1)
    assert link.inbound.frames_until(0.0) == []
    assert [frame.data for frame in link.inbound.frames_until(0.001)] == [b"a"]
    assert link.inbound.frames_until(0.06) == []


def test_a_lost_packet_is_a_frame_without_data() -> None:
    link = Link()
    link.talk(0, 20, lost={3, 7, 8, 9})
    link.play(20 * 0.06 + 0.5)
    assert link.heard[:20] == expected(0, 20, {3, 7, 8, 9})
    assert link.inbound.lost_ms == 60 * link.heard.count(None)


@pytest.mark.parametrize("voice_format", [TWICE, CODEC2])
def test_a_repeated_packet_fills_a_gap(voice_format: VoiceFormat) -> None:
    link = Link(voice_format)
    link.talk(0, 30, lost={4, 9, 15, 20, 21})
    frames = voice_format.frames
    link.play(30 * voice_format.packet_s + WAY_S)
    assert len(link.heard) > 27 * frames
    lost = [index // frames for index, data in enumerate(link.heard) if data is None]
    assert set(lost) == {20}, "of two in a row the first is lost, as the second's repetition is"
    assert [data for data in link.heard if data] == [
        name(i, voice_format) for i in range(len(link.heard)) if i // frames != 20
    ]


def test_the_frames_that_are_repeated_fill_a_gap_in_part() -> None:
    partly = VoiceFormat("codec2", 1200, 40, 5, fixed_size=True, repeated=2)
    link = Link(partly)
    link.talk(0, 30, lost={4, 9, 15, 20, 21})
    link.play(30 * partly.packet_s + WAY_S)
    gaps = {packet: range(3) for packet in (4, 9, 15, 21)} | {20: range(5)}
    lost = {index for index, data in enumerate(link.heard) if data is None}
    assert lost == {5 * packet + frame for packet, frames in gaps.items() for frame in frames}
    assert link.inbound.late == 0


def test_a_pause_is_not_a_loss() -> None:
    link = Link()
    link.talk(0, 5)
    link.silence(0.3)
    assert (link.inbound.state, link.inbound.noise_level) == (VoiceState.SILENT, 60)
    for step in range(30):
        link.play(0.4 + step / 20)
    link.talk(30, 35)
    link.play(35 * 0.06 + 1.0)
    assert link.heard[:10] == expected(0, 5) + expected(30, 35)
    assert link.inbound.state is VoiceState.TALKING


def test_the_beginning_of_a_spurt_may_be_lost() -> None:
    link = Link()
    link.talk(0, 5)
    link.silence(0.3)
    link.talk(8, 12, lost={8})
    link.play(12 * 0.06 + WAY_S + MARGIN_S + 0.01)
    assert link.heard == expected(0, 5) + expected(9, 12)


def test_a_pause_whose_announcement_is_lost_is_concealed_for_a_second_at_most() -> None:
    link = Link()
    link.talk(0, 5)
    link.silence(0.3, is_lost=True)
    for step in range(100):
        link.play(0.4 + step / 20)
    assert link.heard[:5] == expected(0, 5)
    assert MAX_GAP_MS <= 60 * link.heard.count(None) < MAX_GAP_MS + 60
    link.talk(100, 103)
    link.play(103 * 0.06 + 1)
    assert [data for data in link.heard if data] == expected(0, 5) + expected(100, 103)


def test_only_a_packet_that_follows_the_newest_is_awaited() -> None:
    link = Link()
    assert not link.inbound.awaits_packet(10.0)  # nobody has talked
    link.talk(0, 5)
    link.inbound.frames_until(0.25)
    assert not link.inbound.awaits_packet(0.3)  # the fifth packet ends there
    assert link.inbound.awaits_packet(0.301)
    link.inbound.frames_until(0.301)
    assert not link.inbound.awaits_packet(0.361)  # it is concealed by now


def test_nothing_is_awaited_while_nobody_talks() -> None:
    link = Link()
    link.talk(0, 5)
    link.inbound.frames_until(0.25)
    link.silence(0.36)
    assert not link.inbound.awaits_packet(0.4)


def test_an_older_state_changes_nothing() -> None:
    inbound = InboundVoice()
    inbound.receive_format(VoiceFormatMessage(0, OPUS))
    inbound.receive_voice(VoicePayload(0, True, 0, b"a"), 7, 100.0)
    inbound.receive_state(VoiceStateMessage(VoiceState.SILENT, 60), 6)
    assert inbound.state is VoiceState.TALKING
    inbound.receive_state(VoiceStateMessage(VoiceState.OFF, 60), 8)
    inbound.receive_voice(VoicePayload(3, False, 0, b"b"), 5, 100.0)
    assert inbound.state is VoiceState.OFF


def test_a_late_packet_is_counted_and_not_played() -> None:
    link = Link()
    link.talk(0, 5)
    link.outbound.send(VoicePacket(0.3, OPUS, (b"late",)))
    late = [decode_body(outgoing.body) for outgoing in link.outbound.drain()][-1]
    link.talk(6, 12)
    assert isinstance(late, VoicePayload)
    link.inbound.receive_voice(late, 100, 12 * 0.06)
    link.play(12 * 0.06 + WAY_S)
    assert b"late" not in link.heard and link.inbound.late == 1


def test_the_delay_covers_the_packet_and_what_it_repeats() -> None:
    partly = VoiceFormat("codec2", 1200, 40, 5, fixed_size=True, repeated=2)
    for voice_format, packets in ((OPUS, 1), (TWICE, 2), (CODEC2, 2), (partly, 1.4)):
        link = Link(voice_format)
        link.inbound.clock.on_arrival(0.0, WAY_S)  # motion that arrives at once
        link.talk(0, 20)
        assert link.inbound.clock.delay_s == pytest.approx(packets * voice_format.packet_s + MARGIN_S, abs=0.01)
        assert link.inbound.clock.packet_s == voice_format.coverage_s


def test_numbers_are_unwrapped_after_long_silence() -> None:
    link = Link()
    link.talk(0, 3)
    link.silence(0.2)
    link.inbound._peer_clock.set(3600.0, 3600.0 + WAY_S)
    link.talk(60_000, 60_003)
    link.play(60_003 * 0.06 + WAY_S + MARGIN_S + 0.01)
    assert [time for time, _ in link.played[-3:]] == pytest.approx([60_000 * 0.06 + 0.06 * i for i in range(3)])


def test_a_sender_whose_clock_starts_again_is_played_from_there() -> None:
    link = Link()
    link.talk(0, 5)
    link.inbound.clock.on_arrival(0.0, 200.0 + CLOCK_RESET_S)
    link.inbound._peer_clock.set(0.0, 200.0 + CLOCK_RESET_S)
    assert link.inbound.frames_until(1e9) == []


def test_voice_in_an_unknown_format_or_of_a_wrong_size_is_rejected() -> None:
    inbound = InboundVoice()
    with pytest.raises(ProtocolError, match="voice in a format that was not described"):
        inbound.receive_voice(VoicePayload(0, True, 0, b"a"), 0, 0.0)
    inbound.receive_format(VoiceFormatMessage(0, CODEC2))
    with pytest.raises(ProtocolError, match="a voice packet of the wrong length"):
        inbound.receive_voice(VoicePayload(0, True, 0, b"a"), 0, 0.0)
    assert inbound.format is None and inbound.frames_until(1e9) == []


def test_an_empty_frame_is_a_lost_one() -> None:
    inbound = InboundVoice()
    inbound.receive_format(VoiceFormatMessage(0, VoiceFormat("opus", 9000, 60, 2, fixed_size=False)))
    inbound.receive_voice(VoicePayload(0, True, 0, b"\0a"), 0, 0.0)
    assert [frame.data for frame in inbound.frames_until(0.1)] == [None, b"a"]
    assert inbound.lost_ms == 60


@pytest.mark.slow
def test_what_nobody_plays_is_bounded() -> None:
    inbound = InboundVoice()
    inbound.receive_format(VoiceFormatMessage(0, VoiceFormat("x", 8000, 20, 1, fixed_size=False)))
    for count in range(3 * MAX_FRAMES):
        inbound.receive_voice(VoicePayload(count % 512, True, 0, b"a"), count, count / 50)
        inbound.receive_state(VoiceStateMessage(VoiceState.SILENT, 0), count)
    assert len(inbound._frames) == MAX_FRAMES
    assert len(inbound._begins) <= MAX_FRAMES and len(inbound._ends) <= MAX_FRAMES


PAYLOADS = st.builds(
    VoicePayload, st.integers(0, 511), st.booleans(), st.integers(0, 3), st.binary(min_size=1, max_size=90)
)


@pytest.mark.slow
@given(
    st.lists(
        st.tuples(
            PAYLOADS | st.sampled_from([state for state in VoiceState if state is not VoiceState.TALKING]),
            st.floats(0, 3),
        ),
        max_size=60,
    )
)
def test_any_voice_is_played_in_order_without_overlap_of_more_than_a_frame(
    events: list[tuple[VoicePayload | VoiceState, float]],
) -> None:
    inbound = InboundVoice()
    for number, voice_format in enumerate((OPUS, TWICE, CODEC2)):
        inbound.receive_format(VoiceFormatMessage(number, voice_format))
    now, frames = 0.0, []
    for counter, (event, wait_s) in enumerate(events):
        now += wait_s
        try:
            if isinstance(event, VoiceState):
                inbound.receive_state(VoiceStateMessage(event, 60), counter)
            else:
                inbound.receive_voice(event, counter, now)
        except ProtocolError:
            continue
        frames += inbound.frames_until(inbound.clock.playhead(now))
    assert all(b.timestamp > a.timestamp - 0.06 for a, b in pairwise(frames))
    assert inbound.lost_ms == sum(frame.format.frame_ms for frame in frames if frame.data is None)
    assert len(frames) <= 40 * (len(events) + 1)
