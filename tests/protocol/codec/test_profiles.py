"""The profiles: their values, and what they cost in delay and headers."""

import pytest

from conf.protocol.codec.profiles import LIVE, NARROWBAND, PROFILES, RICH, Profile

HEADERS = 28 + 14  # UDP/IP, framing and seal


def test_the_profiles_are_those_of_the_wire_format() -> None:
    assert list(PROFILES.values()) == [
        Profile(
            "live", 15, 1, 0.0094, rd_lambda=0.10, target_bits=64, tables="live", usual_counts=(1,), skip_threshold=1.15
        ),
        Profile("rich", 30, 2, 0.006, rd_lambda=0.05, target_bits=64, tables="rich", usual_counts=(2,)),
        Profile("narrow", 15, 3, 0.0136, rd_lambda=0.065, target_bits=40, tables="narrow", usual_counts=(3,)),
        Profile("voice", 50 / 3, 1, 0.0094, rd_lambda=0.10, target_bits=64, tables="live", usual_counts=(1, 2)),
        Profile("slow", 12.5, 3, 0.015, rd_lambda=0.055, target_bits=40, tables="narrow", usual_counts=(3, 6)),
    ]
    assert [profile.name for profile in PROFILES.values()] == list(PROFILES)


def test_grouping_frames_adds_delay() -> None:
    assert LIVE.delay == 0
    assert pytest.approx(1 / 30) == RICH.delay
    assert pytest.approx(2 / 15) == NARROWBAND.delay


@pytest.mark.parametrize(
    ("profile", "bits_a_second", "payload_bytes_a_frame"), [(LIVE, 5800, 6), (NARROWBAND, 2400, 6), (RICH, 11000, 8)]
)
def test_headers_leave_room_for_the_motion(profile: Profile, bits_a_second: int, payload_bytes_a_frame: int) -> None:
    bytes_a_second = profile.fps * (HEADERS / profile.frames_per_datagram + payload_bytes_a_frame)
    assert bytes_a_second * 8 <= bits_a_second
