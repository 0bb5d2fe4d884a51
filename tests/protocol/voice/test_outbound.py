from itertools import pairwise

import pytest

from conf.protocol.messages import VoiceFormatMessage, VoicePayload, VoiceStateMessage
from conf.protocol.outgoing import OutgoingBody
from conf.protocol.stream_clocks import StreamClock
from conf.protocol.voice.formats import VoiceFormat, VoicePacket, VoiceState
from conf.protocol.voice.outbound import (
    MAX_IN_FLIGHT,
    MAX_JITTER_S,
    MAX_QUEUED,
    NOISE_TOLERANCE,
    STATE_REPEAT_S,
    STATE_WAIT_S,
    OutboundVoice,
)
from conf.protocol.voice.packing import unpack_frames
from conf.protocol.wire import decode_body

OPUS = VoiceFormat("opus", 9000, 60, 1, fixed_size=False)
TWICE = VoiceFormat("opus", 5000, 60, 1, fixed_size=False, repeated=1)


def packet(timestamp: float, voice_format: VoiceFormat = OPUS, data: bytes = b"voice") -> VoicePacket:
    return VoicePacket(timestamp, voice_format, (data,) * voice_format.frames)


def bodies(voice: OutboundVoice) -> list[object]:
    return [decode_body(outgoing.body) for outgoing in voice.drain()]


def payloads(voice: OutboundVoice) -> list[VoicePayload]:
    return [body for body in bodies(voice) if isinstance(body, VoicePayload)]


def sent(voice: OutboundVoice, stamps: list[float]) -> list[VoicePayload]:
    result = []
    for stamp in stamps:
        voice.send(packet(stamp))
        result += payloads(voice)
    return result


def test_a_talk_spurt_is_numbered_without_gaps_on_the_stream_clock() -> None:
    stamps = [50.0 + 0.06 * i for i in range(200)]
    numbers = [payload.number for payload in sent(OutboundVoice(), stamps)]
    assert numbers[:3] == [0, 3, 6]
    assert all((b - a) % 512 == 3 for a, b in pairwise(numbers)) and max(numbers) < 512


def test_small_errors_of_capture_times_leave_no_gap_and_larger_ones_begin_a_spurt() -> None:
    late = MAX_JITTER_S - 0.001
    first, second, third, fourth, fifth = sent(OutboundVoice(), [0.0, 0.06 + late, 0.12 - late, 0.18 + 0.2, 0.3])
    assert [payload.begins for payload in (first, second, third)] == [True, False, False]
    assert (first.number, second.number, third.number) == (0, 3, 6)
    assert (fourth.number, fourth.begins) == (19, True)
    assert fifth.number == 22, "packets never overlap"


def test_the_clock_is_shared_and_voice_before_its_start_is_dropped() -> None:
    clock = StreamClock()
    voice = OutboundVoice(clock)
    clock.stream_time(10.0)
    assert sent(voice, [9.95]) == []
    (payload,) = sent(voice, [10.1])
    assert payload.number == 5


def test_the_format_goes_along_until_it_is_acknowledged() -> None:
    voice = OutboundVoice()
    for counter in range(3):
        voice.send(packet(0.06 * counter))
        first, second = voice.drain()
        assert decode_body(first.body) == first.voice_format == VoiceFormatMessage(0, OPUS)
        assert isinstance(decode_body(second.body), VoicePayload) and second.voice_format is None
        voice.on_sent(counter, first)
    voice.on_acknowledged([1])
    voice.send(packet(0.18))
    assert [type(body) for body in bodies(voice)] == [VoicePayload]
    voice.send(packet(0.24, TWICE))
    message, payload = bodies(voice)
    assert message == VoiceFormatMessage(1, TWICE)
    assert isinstance(payload, VoicePayload) and payload.format_number == 1


def test_the_seventeenth_format_takes_the_number_not_used_for_longest() -> None:
    voice = OutboundVoice()
    numbers: list[int] = []
    for count in [*range(16), 0, 16, 1]:
        voice.send(packet(10.0 * len(numbers), VoiceFormat("opus", 9000 + count, 60, 1, fixed_size=False)))
        message, payload = bodies(voice)
        assert isinstance(message, VoiceFormatMessage) and isinstance(payload, VoicePayload)
        assert message.format_number == payload.format_number
        numbers.append(payload.format_number)
    assert numbers == [*range(16), 0, 1, 2]


def test_a_redundant_packet_repeats_the_one_before_it_in_the_same_spurt_and_format() -> None:
    voice = OutboundVoice()
    for stamp, voice_format, data in [
        (0.0, OPUS, b"a"),
        (0.06, TWICE, b"b"),
        (0.12, TWICE, b"c"),
        (0.18, TWICE, b"d"),
        (0.5, TWICE, b"e"),
    ]:
        voice.send(packet(stamp, voice_format, data))
        (payload,) = payloads(voice)
        if data in b"abe":
            assert payload.begins and payload.data == data
        else:
            assert not payload.begins
            assert unpack_frames(payload.data, TWICE, 2) == [data, bytes((data[0] - 1,))]


@pytest.mark.parametrize("repeated", [1, 2, 3])
def test_of_a_long_packet_the_newest_frames_are_repeated(repeated: int) -> None:
    voice, three = OutboundVoice(), VoiceFormat("opus", 5000, 20, 3, fixed_size=False, repeated=repeated)
    for stamp, frames in ((0.0, (b"a", b"b", b"c")), (0.06, (b"d", b"e", b"f"))):
        voice.send(VoicePacket(stamp, three, frames))
    _, payload = payloads(voice)
    assert unpack_frames(payload.data, three, 3 + repeated) == [b"d", b"e", b"f", *(b"a", b"b", b"c")[3 - repeated :]]


def test_packets_that_are_not_as_their_format_says_are_refused() -> None:
    voice = OutboundVoice()
    with pytest.raises(ValueError, match="a packet of this format has 1 frames, not 2"):
        voice.send(VoicePacket(0.0, OPUS, (b"a", b"b")))
    with pytest.raises(ValueError, match="a voice frame of 48 bits has 6 bytes, not 5"):
        voice.send(packet(0.0, VoiceFormat("codec2", 1200, 40, 2, fixed_size=True)))


def test_packets_that_nobody_collects_are_bounded() -> None:
    voice = OutboundVoice()
    for count in range(10):
        voice.send(packet(0.06 * count))
    assert voice.has_packet and voice.waiting_bytes == MAX_QUEUED * (2 + 5 + 1)
    assert [payload.number for payload in payloads(voice)] == [18, 21, 24, 27]
    assert not voice.has_packet


def states(voice: OutboundVoice, now: float, *, alone: bool = False) -> list[OutgoingBody]:
    return voice.state_bodies(now, alone=alone)


def test_the_end_of_talk_is_announced_until_it_is_acknowledged() -> None:
    voice = OutboundVoice()
    assert states(voice, 0.0) == []
    voice.send(packet(0.0))
    assert voice.state is VoiceState.TALKING and states(voice, 0.0) == []
    voice.set_state(VoiceState.SILENT, 60, 1.0)
    (first,) = states(voice, 1.0, alone=True)
    assert first.voice_state == decode_body(first.body) == VoiceStateMessage(VoiceState.SILENT, 60)
    voice.on_sent(7, first)
    assert states(voice, 1.01) == [first]
    voice.on_acknowledged([7])
    assert states(voice, 1.02) == []


def test_a_state_waits_for_another_datagram_before_it_is_sent_alone() -> None:
    voice = OutboundVoice()
    voice.set_state(VoiceState.SILENT, 60, 1.0)
    assert states(voice, 1.0 + STATE_WAIT_S - 0.01, alone=True) == []
    assert len(states(voice, 1.0 + STATE_WAIT_S, alone=True)) == 1
    assert states(voice, 1.0 + STATE_WAIT_S + STATE_REPEAT_S - 0.01, alone=True) == []
    assert len(states(voice, 1.0 + STATE_WAIT_S + STATE_REPEAT_S, alone=True)) == 1


def test_only_a_change_is_announced() -> None:
    voice = OutboundVoice()
    voice.set_state(VoiceState.OFF, 100, 0.0)
    assert states(voice, 0.0) == [], "a receiver expects no voice at first"
    for noise, is_sent in ((60, True), (60 + NOISE_TOLERANCE - 1, False), (60 - NOISE_TOLERANCE, True), (500, True)):
        voice.set_state(VoiceState.SILENT, noise, 0.0)
        announced = states(voice, 0.0)
        assert bool(announced) == is_sent
        for outgoing in announced:
            voice.on_sent(noise, outgoing)
        voice.on_acknowledged([noise])
    assert announced[0].voice_state == VoiceStateMessage(VoiceState.SILENT, 127)
    voice.set_state(VoiceState.TALKING, 60, 0.0)
    assert states(voice, 0.0) == []


def test_the_acknowledgement_of_an_earlier_state_like_it_is_not_enough() -> None:
    voice = OutboundVoice()
    voice.set_state(VoiceState.SILENT, 60, 0.0)
    (first,) = states(voice, 0.0)
    voice.on_sent(1, first)
    voice.set_state(VoiceState.OFF, 60, 0.0)
    voice.on_sent(2, states(voice, 0.0)[0])
    voice.set_state(VoiceState.SILENT, 60, 0.0)
    voice.on_acknowledged([1])
    assert len(states(voice, 0.0)) == 1


@pytest.mark.parametrize("state", [VoiceState.SILENT, VoiceState.MUTED, VoiceState.NO_ROOM])
def test_a_new_session_is_told_why_no_voice_comes(state: VoiceState) -> None:
    voice = OutboundVoice()
    voice.set_state(state, 127, 0.0)
    voice.restart()
    assert [o.voice_state for o in states(voice, 0.0)] == [VoiceStateMessage(state, 127)]


def test_voice_after_silence_begins_a_spurt_even_without_a_gap() -> None:
    voice = OutboundVoice()
    sent(voice, [0.0])
    voice.set_state(VoiceState.SILENT, 60, 0.06)
    (payload,) = sent(voice, [0.06])
    assert (payload.number, payload.begins) == (3, True)


def test_a_new_session_starts_from_nothing_but_the_state() -> None:
    voice = OutboundVoice()
    voice.send(packet(0.0))
    (message, payload) = voice.drain()
    voice.on_sent(0, message)
    voice.on_acknowledged([0])
    voice.set_state(VoiceState.SILENT, 60, 0.0)
    voice.send(packet(5.0))
    voice.set_state(VoiceState.SILENT, 60, 5.1)
    voice.restart()
    assert not voice.has_packet
    assert [o.voice_state for o in states(voice, 6.0, alone=True)] == [VoiceStateMessage(VoiceState.SILENT, 60)]
    voice.send(packet(70.0))
    first, second = bodies(voice)
    assert first == VoiceFormatMessage(0, OPUS) and isinstance(second, VoicePayload) and second.number == 0
    assert payload.body


def test_memory_of_sent_datagrams_is_bounded() -> None:
    voice = OutboundVoice()
    for counter in range(2 * MAX_IN_FLIGHT):
        voice.on_sent(counter, OutgoingBody(b"", voice_format=VoiceFormatMessage(0, OPUS)))
        voice.on_sent(counter, OutgoingBody(b""))
    assert list(voice._in_flight) == list(range(MAX_IN_FLIGHT, 2 * MAX_IN_FLIGHT))
