"""The profiles keep their promises about delay and headers."""

import pytest

from conf.protocol.codec.profiles import LIVE, NARROWBAND, PROFILES, RICH, Profile

HEADERS = 28 + 14  # UDP/IP, framing and seal


def test_live_adds_no_delay() -> None:
    assert LIVE.delay == 0
    assert (LIVE.fps, LIVE.frames_per_datagram) == (15, 1)


@pytest.mark.parametrize(
    ("profile", "bits_a_second", "payload_bytes_a_frame"), [(LIVE, 5800, 6), (NARROWBAND, 2400, 6), (RICH, 11000, 8)]
)
def test_headers_leave_room_for_the_motion(profile: Profile, bits_a_second: int, payload_bytes_a_frame: int) -> None:
    bytes_a_second = profile.fps * (HEADERS / profile.frames_per_datagram + payload_bytes_a_frame)
    assert bytes_a_second * 8 <= bits_a_second


def test_names_are_the_keys() -> None:
    assert [profile.name for profile in PROFILES.values()] == list(PROFILES)
