"""Simulated calls of two: limits, losses, silence and costs of both directions."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from conf.protocol.messages import MotionFrame
from conf.protocol.motion.furrow_announcer import FURROW_BYTES
from conf.protocol.rate_control.rate_levels import VoiceMode
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.voice.formats import VoiceState
from conf.protocol.wire import FURROWS, split_bodies
from tests.support.simulated_calls import frown
from tests.support.two_way_call import Losses, Motion, TwoWayCall
from tools.bench.tracks import TrackReader

RATES = [16.0, 9.6, 6.0, 4.8, 2.4]


@pytest.mark.slow
@pytest.mark.parametrize("kbps", RATES)
@pytest.mark.parametrize("fill", [0.85, 1.0])
def test_two_talkers_keep_the_limit_and_no_voice_is_lost(kbps: float, fill: float) -> None:
    """fill : mean size of Opus frames over the nominal one; 1 with little spread is worse than speech ever is."""
    call = TwoWayCall(RateOptions(kbps=kbps, voice=VoiceMode.AUTOMATIC))
    for talker in (call.a, call.b):
        talker.mean_fill, talker.spread = fill, 0.08 if fill < 1 else 0.0
    call.run(22)
    for talker, other in ((call.a, call.b), (call.b, call.a)):
        assert talker.max_kbps() <= kbps
        assert other.receive.rejected == other.receive.missed_references == other.receive.voice.late == 0
        assert other.lost_voice == 0
        assert [frame.data for frame in other.played] == [talker.sent[round(f.timestamp, 3)] for f in other.played]
        assert len(other.played) * other.played[0].format.frame_ms / 1000 > 20.5
        assert talker.sealing_key.counter - talker.sealing_key.acknowledged < 40
        fps = talker.send.motion.frames_sent / 22
        assert fps > (6 if fill == 1 else 9)


# Of 20 % of the datagrams, frames: 9.6 kbit/s repeat half of each packet, 2.4 nothing, the others all.
ALLOWED_LOSS = {16.0: 0.09, 9.6: 0.17, 6.0: 0.09, 4.8: 0.09, 2.4: 0.3}


@pytest.mark.slow
@pytest.mark.parametrize(("kbps", "burst"), [*((kbps, 1) for kbps in RATES), (16.0, 3), (4.8, 3)])
def test_redundancy_fills_losses_within_the_limit(kbps: float, burst: int) -> None:
    call = TwoWayCall(RateOptions(kbps=kbps, voice=VoiceMode.AUTOMATIC), losses=Losses(0.2, burst))
    call.run(50)
    for talker, other in ((call.a, call.b), (call.b, call.a)):
        assert talker.max_kbps() <= kbps
        assert other.receive.rejected == 0
        if kbps > 9.6 or (kbps > 2.4 and burst == 1):  # elsewhere repeating whole packets does not help against bursts
            assert talker.send.voice_format and talker.send.voice_format.repeated
        recent = other.played[len(other.played) // 2 :]
        lost = sum(frame.data is None for frame in recent) / len(recent)
        assert lost < (ALLOWED_LOSS[kbps] if burst == 1 else 0.3)
        assert all(f.data is None or f.data == talker.sent[round(f.timestamp, 3)] for f in other.played)
        assert talker.send.status(call.now).profile == other.send.status(call.now).profile


@pytest.mark.slow
@pytest.mark.parametrize("kbps", [16.0, 4.8])
def test_ten_per_cent_of_loss_does_not_lower_the_level(kbps: float) -> None:
    call = TwoWayCall(RateOptions(kbps=kbps, voice=VoiceMode.AUTOMATIC), losses=Losses(0.1))
    call.run(40)
    for talker in (call.a, call.b):
        assert talker.send.voice_format
        assert talker.send.voice_format.codec == ("opus" if kbps > 9 else "codec2")
        settled = talker.played[len(talker.played) // 2 :]  # repetition begins when the loss is certain
        assert sum(frame.data is None for frame in settled) / len(settled) < (0.16 if kbps > 9 else 0.12)
        assert talker.max_kbps() <= kbps


@pytest.mark.slow
def test_silence_costs_no_voice_and_is_no_loss() -> None:
    call = TwoWayCall(RateOptions(kbps=6.0, voice=VoiceMode.AUTOMATIC), losses=Losses(0.1))
    for second in range(24):
        call.a.is_talking = second % 8 < 4
        call.run(1)
    assert call.b.receive.voice.lost_ms < 0.1 * 12_000
    talked = sum(frame.format.frame_ms for frame in call.b.played) / 1000
    assert talked == pytest.approx(12, abs=2)
    assert call.b.receive.voice.state is VoiceState.SILENT and call.b.receive.voice.noise_level == 60


def track(name: str) -> Motion:
    """Return the motion of a recorded talker, again and again."""
    path = Path(__file__).resolve().parents[3] / "shared" / "motion" / f"{name}.npz"
    if not path.is_file():
        pytest.skip(f"the tracks are not in {path.parent}")
    frames = TrackReader().read(path, fps=15).frames
    return lambda timestamp: replace(frames[round(timestamp * 15) % len(frames)], timestamp=timestamp)


@pytest.mark.slow
@pytest.mark.parametrize(("profile", "max_kbps"), [("live", 5.4), ("narrow", 2.3)])
@pytest.mark.parametrize("loss", [0.0, 0.05])
def test_two_ways_cost_less_a_direction_than_one_way(profile: str, max_kbps: float, loss: float) -> None:
    call = TwoWayCall(RateOptions(profile), motions=(track("talk_1"), track("talk_4")), losses=Losses(loss))
    call.run(40)
    for talker in (call.a, call.b):
        assert talker.kbps(0, 40) < max_kbps + (0.15 if loss else 0.0)
        assert talker.receive.missed_references == talker.receive.rejected == 0
        assert len(talker.wire) / 40 < (15.2 if profile == "live" else 5.3), "reports ride"


@pytest.mark.slow
@pytest.mark.parametrize("loss", [0.0, 0.1])
def test_furrows_cost_less_than_half_a_byte_a_frame_and_arrive(loss: float) -> None:
    call, seen = TwoWayCall(RateOptions("live"), motions=(frown, None), losses=Losses(loss)), []
    for _ in range(100):
        call.run(0.4)
        playout = call.b.receive.motion.frame_at(call.now)
        seen.append(playout.frame.furrow if playout else 0.0)
    sent = [part for body in call.a.bodies for part in split_bodies(body) if part[0] == FURROWS]
    assert 20 < len(sent) < 0.5 * call.a.send.motion.frames_sent / FURROW_BYTES
    assert max(seen) > 0.8 and min(seen) == 0.0 and 0.2 < np.mean(np.array(seen) > 0.4) < 0.5


@pytest.mark.slow
def test_lips_and_voice_are_due_at_the_same_time() -> None:
    def marked(timestamp: float) -> MotionFrame:
        return MotionFrame(
            timestamp, np.zeros((50, 3), np.float32), np.array([0, 0.5 * np.sin(2 * timestamp), 0, 0, 0, -3.3])
        )

    call = TwoWayCall(RateOptions(kbps=6.0, voice=VoiceMode.AUTOMATIC), motions=(marked, marked))
    call.run(10)
    begin = len(call.b.played)
    for _ in range(100):
        call.run(0.05)
        playout = call.b.receive.motion.frame_at(call.now)
        assert playout is not None and playout.age_s < 0.4, "only the turning points hold still"
        newest = call.b.played[-1]
        assert 0 <= playout.frame.timestamp - newest.timestamp <= 0.03 + newest.format.frame_ms / 1000
        assert playout.frame.pose[1] == pytest.approx(
            0.5 * np.sin(2 * playout.frame.timestamp), abs=0.08
        )  # of one radian a second
    stamps = [frame.timestamp for frame in call.b.played[begin:]]
    assert all(b - a == pytest.approx(0.02) for a, b in pairwise(stamps))
