"""Every byte of a recorded call, decoded by an independent implementation of WIRE.md without conf.protocol."""

import hashlib
import hmac
import random
import zlib
from collections.abc import Callable, Iterable, Iterator
from itertools import groupby

import msgpack
import numpy as np
import pytest
from cryptography.hazmat.primitives.ciphers.aead import AESCCM
from spake2 import SPAKE2_A

from conf.protocol.address import Address
from conf.protocol.rate_control.rate_levels import VoiceMode
from conf.protocol.rate_control.send_budget import RateOptions
from tests.protocol.independent_decoder import (
    PayloadReader,
    read_furrows,
    read_participant,
    read_voice,
    read_voice_frames,
    split_composite,
)
from tests.protocol.session.test_golden import hkdf_expand
from tests.protocol.test_call_endpoint import endpoint, send_frames
from tests.support.simulated_call import A, B, Link
from tests.support.simulated_calls import SimulatedSender, World, frown, talk
from tests.support.simulated_sessions import CODE, RECEIVER
from tests.support.two_way_call import Losses, Talker, TwoWayCall

FIELDS = {0: 48, 1: 16, 2: 40, 3: 25, 4: 25, 5: 10, 6: 1}
COUNTS = {0: 10, 1: 2, 3: 1}  # fields of the bodies that are a plain array
NEW: Address = ("203.0.113.1", 7)
Capture = list[tuple[float, Address, Address, bytes]]


@pytest.fixture(scope="module")
def call() -> tuple[World, SimulatedSender]:
    """Make a call of ten seconds, some of it with losses, ended by a Bye."""
    world = World(seed="capture")
    sender = world.call()
    world.run(4)
    sender.line.loss = 0.1
    world.run(6)
    sender.line.loss = 0.0
    sender.motion = None
    world.send(sender.connection.close(world.now), sender.address)
    world.run(0.2)
    return world, sender


@pytest.fixture(scope="module")
def capture(call: tuple[World, SimulatedSender]) -> Capture:
    """Return all datagrams of the call."""
    return call[0].traffic


def handshakes(capture: Capture) -> dict[int, bytes]:
    """Check each handshake datagram; return the last one of each kind."""
    found = {}
    for _, source, _, data in capture:
        if data[0] != 0x93:
            continue
        kind = data[2]
        assert data[:2] == b"\x93\x03" and data[3] == 0xC4 and data[4] == FIELDS[kind] + 4 == len(data) - 5
        assert zlib.crc32(data[:-4]) == int.from_bytes(data[-4:])
        assert (source == RECEIVER) == (kind in {1, 2, 4, 5, 6})
        found[kind] = data[5:-4]
    return found


def secrets(handshake: dict[int, bytes], random_bytes: Callable[[int], bytes]) -> tuple[int, bytes, bytes]:
    """Return session and the secrets of both directions, given the sender's random bytes."""
    attempt = random_bytes(8)
    spake = SPAKE2_A(CODE.encode(), idA=b"conf sender", idB=b"conf receiver", entropy_f=random_bytes)
    share = spake.start()[1:]
    assert handshake[0][:8] == attempt and handshake[0][16:] == share
    key = spake.finish(b"B" + handshake[2][8:])
    transcript = hashlib.sha256(b"\x03conf senderconf receiver" + attempt + share + handshake[2][8:]).digest()
    material = hkdf_expand(hmac.digest(transcript, key, "sha256"), b"conf session", 128)
    return handshake[4][8], material[:32], material[32:64]


def bodies(capture: Capture, session: int, secret: bytes, *, to_receiver: bool) -> Iterator[tuple[int, bytes]]:
    """Open each data datagram of one direction in the order of sending: counter and body, those of composites apart."""
    datagrams = (data for _, _, target, data in capture if data[0] == 0x94 and (target == RECEIVER) == to_receiver)
    for counter, body in open_all(datagrams, session, secret):
        yield from ((counter, part) for part in split_composite(body))


def open_all(datagrams: Iterable[bytes], session: int, secret: bytes) -> Iterator[tuple[int, bytes]]:
    """Open the data datagrams of one direction in the order of sending: counter and body."""
    material = hkdf_expand(secret, b"conf epoch", 53)
    cipher = AESCCM(material[:16], tag_length=8)
    counter = 0
    for data in datagrams:
        assert data[:3] == bytes((0x94, 3, session)) and 10 <= len(data) <= 1200
        if data[3] < 0x80:
            assert data[3] == counter & 0x7F
            at = 4
        else:
            width = {0xCC: 1, 0xCD: 2, 0xCE: 4}[data[3]]
            at = 4 + width
            assert int.from_bytes(data[4:at]) == counter >= 128
        assert data[at] == 0xC4 and data[at + 1] == len(data) - at - 2
        header, sealed = data[: at + 2], data[at + 2 :]
        yield counter, cipher.decrypt(material[16:21] + counter.to_bytes(8), sealed, header)
        counter += 1


@pytest.mark.slow
def test_every_body_is_as_wire_md_describes(capture: Capture) -> None:
    handshake = handshakes(capture)
    assert set(handshake) - {6} == {0, 1, 2, 3, 4}  # the second Bye finds no session
    sender = ("198.51.100.1", 40000)
    session, from_sender, _ = secrets(handshake, random.Random(f"{sender} capture").randbytes)
    kinds, clock, number = [], -1, -1
    for _, body in bodies(capture, session, from_sender, to_receiver=True):
        kinds.append(min(body[0], 0x80))
        if body[0] & 0x80:
            step = (body[0] & 0x7F) - number & 0x7F if number >= 0 else 1
            assert 0 < step <= 12 and 1 <= len(body) <= 60
            number = body[0] & 0x7F
        elif body[0] == 4:
            assert body == b"\x04"
        else:
            fields = msgpack.unpackb(body[1:])
            assert len(fields) == COUNTS[body[0]] and all(0 <= n < 1 << 48 for n in fields)
            if body[0] in (0, 1):
                assert fields[0] >= clock
                clock = fields[0]
            if body[0] == 0:
                assert fields[1:] == [320, 240, 1500, 50, 6400, 4200, 2000, 5100, 1100]
    assert kinds[0] == 0 and kinds[-2:] == [4, 4]
    assert kinds.count(0x80) > 90 and kinds.count(3) >= 1


@pytest.mark.slow
def test_every_payload_is_the_motion_that_was_captured(call: tuple[World, SimulatedSender], capture: Capture) -> None:
    sender = call[1]
    session, from_sender, _ = secrets(handshakes(capture), random.Random(f"{sender.address} capture").randbytes)
    reader, number = PayloadReader(), 0
    poses, errors, moves = [], [], []
    for _, body in bodies(capture, session, from_sender, to_receiver=True):
        if not body[0] & 0x80:
            continue
        number += (body[0] - number) & 0x7F
        profile, stride, numbers = reader.read(body[1:], number)
        for at in numbers:
            displacements, pose = reader.motion(profile, at, stride)
            frame = sender.frames[min(sender.frames, key=lambda t: abs(t - sender.origin - at / 15))]
            poses.append(np.abs(pose - frame.pose))
            errors.append(displacements[:, :2] - frame.displacements[:, :2])
            moves.append(frame.displacements[:, :2])
    assert len(errors) > 90
    assert (np.max(poses, axis=0) < [0.05, 0.05, 0.03, 0.01, 0.01, 0.03]).all()
    assert float(np.square(errors).mean()) < 0.2 * float(np.square(moves).mean())  # a grimace takes some frames


def test_every_report_is_as_wire_md_describes(capture: Capture) -> None:
    handshake = handshakes(capture)
    sender = ("198.51.100.1", 40000)
    session, _, from_receiver = secrets(handshake, random.Random(f"{sender} capture").randbytes)
    newest = lost = 0
    count = 0
    for _, body in bodies(capture, session, from_receiver, to_receiver=False):
        assert body[0] in (0x02, 0x0A)
        highest, missing, lost_now, jitter, ack_delay = msgpack.unpackb(b"\x95" + body[1:])
        assert highest >= newest and lost_now >= lost - 2 and lost_now <= highest
        assert missing < 1 << min(highest, 63) and jitter < 100 and ack_delay < 600
        newest, lost, count = highest, lost_now, count + 1
    assert 18 <= count <= 23 and lost > 0


# The order of bodies in a composite; motion is 0x80, voice 0x40.
ORDER = [2, 10, 6, 0, 3, 11, 8, 9, 1, 15, 0x80, 0x40, 4, 5]


def kind(body: bytes) -> int:
    return 0x80 if body[0] & 0x80 else 0x40 if body[0] & 0x40 else body[0]


@pytest.mark.slow
@pytest.mark.parametrize("kbps", [16.0, 6.0, 2.4])
def test_every_byte_of_a_call_with_voice_is_as_wire_md_describes(kbps: float) -> None:
    rate = RateOptions(kbps=kbps, voice=VoiceMode.AUTOMATIC)
    call = TwoWayCall(rate, motions=(frown, talk), losses=Losses(0.15))
    for second in range(20):
        call.a.is_talking = second % 10 < 8
        call.run(1)
    kinds = read_talker(call.a)
    assert kinds >= {0, 2, 3, 8, 9, 15, 0x80, 0x40}


def read_talker(talker: Talker) -> set[int]:
    """Check all that a talker has sent; return the kinds of bodies."""
    formats: dict[int, tuple[str, int, int, int, int]] = {}
    reader, number, voice_number, ends, heard, found = PayloadReader(), 0, 0, set(), set(), set()
    levels = {0}
    for _, body in open_all(talker.datagrams, 5, talker.secret):
        parts = split_composite(body)
        assert [ORDER.index(kind(part)) for part in parts] == sorted(ORDER.index(kind(part)) for part in parts)
        for part in parts:
            found.add(kind(part))
            match kind(part):
                case 0x80:
                    number += (part[0] - number) & 0x7F
                    reader.read(part[1:], number)
                case 15:
                    levels.add(read_furrows(part))
                case 8:
                    format_number, *fields = msgpack.unpackb(part[1:])
                    formats[format_number] = tuple(fields)
                case 9:
                    assert part in (b"\x09\0\x7f", b"\x09\1\x3c")
                case 0x40:
                    low_bits, begins, format_number, data = read_voice(part)
                    voice_number += (low_bits - voice_number) & 511
                    codec, bit_rate, frame_ms, frames, coding = formats[format_number]
                    assert codec in ("opus", "codec2") and begins == ((voice_number, format_number) not in ends)
                    repeated = 0 if begins else coding >> 1
                    fixed_bits = bit_rate * frame_ms // 1000 if coding & 1 else None
                    for position, frame in enumerate(read_voice_frames(data, frames + repeated, fixed_bits=fixed_bits)):
                        at = position if position < frames else position - frames - repeated
                        stamp = round(voice_number * 0.02 + at * frame_ms / 1000, 3)
                        assert talker.sent[stamp] == frame
                        heard.add(stamp)
                    ends.add((voice_number + frame_ms * frames // 20, format_number))
    assert len(heard) > 0.98 * len(talker.sent)
    assert max(levels) >= 5
    return found


@pytest.mark.slow
def test_names_cameras_portraits_and_path_probes_of_a_call_of_two_are_as_wire_md_describes() -> None:
    called, calling = endpoint("Zoë"), endpoint("Bob", A, head=5)
    link = Link({A: called, B: calling}, delays=lambda _: [0.04])
    frames = send_frames(called, calling)
    link.tick = frames
    link.run(2)
    link.move(B, NEW)
    link.run(2)
    link.tick = lambda now: calling.send_camera_off(now)
    link.run(3)
    link.tick = frames
    link.run(1)
    calling.set_portrait_allowed(True, link.now)
    calling.set_portrait_allowed(False, link.now)
    link.run(1)
    capture = [(at, source, RECEIVER if target == A else target, data) for at, source, target, data in link.sent]
    random_bytes = random.Random("Bob").randbytes
    random_bytes(32 + 1)  # for answers, which it does not give
    sent = {data[2]: data[5:-4] for _, _, _, data in capture if data[0] == 0x93}
    session, from_caller, from_called = secrets(sent, random_bytes)
    participants: dict[bool, list[tuple[bool, bool, int, str]]] = {True: [], False: []}
    probes: dict[bool, list[bytes]] = {True: [], False: []}
    answers: dict[bool, list[bytes]] = {True: [], False: []}
    camera_is_on = True
    for is_calling, secret in ((True, from_caller), (False, from_called)):
        for _, part in bodies(capture, session, secret, to_receiver=is_calling):
            if part[0] == 0x0B:
                participants[is_calling].append(read_participant(part))
                camera_is_on = participants[is_calling][-1][0]
            elif part[0] in (0x0C, 0x0D):
                (probes if part[0] == 0x0C else answers)[is_calling].append(part[1:])
                assert len(part) == 9
            else:
                assert camera_is_on or part[0] in (2, 10, 3), "nothing of the face"
                assert kind(part) in ORDER
    assert set(participants[False]) == {(True, False, 0, "Zoë")}
    states = [(True, False), (False, False), (True, False), (True, True)]
    assert [key for key, _ in groupby(participants[True])] == [(*state, 5, "Bob") for state in states]
    assert not probes[True] and probes[False] and set(answers[True]) == set(probes[False]) and not answers[False]
