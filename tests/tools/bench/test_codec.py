"""Rate and error of every profile on tracks that were not used for training, and the keys of --json."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from conf.protocol.codec.profiles import LIVE, NARROWBAND, RICH, Profile
from tools.bench.codec_link import HELD_OUT, Link, Result, measure, total
from tools.bench.tracks import Track, TrackReader

pytestmark = pytest.mark.slow

TOOL = Path(__file__).resolve().parents[3] / "tools" / "bench" / "codec.py"


@pytest.fixture(scope="module")
def tracks() -> dict[float, list[Track]]:
    folder = TOOL.parents[3] / "shared" / "motion"
    if not folder.is_dir():
        pytest.skip(f"the tracks are not in {folder}")
    reader = TrackReader()
    return {fps: [reader.read(folder / f"{name}.npz", fps=fps) for name in HELD_OUT] for fps in (15, 30)}


def run(tracks: dict[float, list[Track]], profile: Profile, link: Link) -> Result:
    return total([measure(track, profile, link) for track in tracks[profile.fps]])


def test_live_keeps_its_rate_and_error(tracks: dict[float, list[Track]]) -> None:
    acknowledged, unacknowledged = run(tracks, LIVE, Link(ack_delay=2)), run(tracks, LIVE, Link(ack_delay=0))
    assert acknowledged.payload_bytes_per_frame <= 6.0
    assert unacknowledged.payload_bytes_per_frame <= 8.8  # 6.2 kbit/s, as README says
    for result in (acknowledged, unacknowledged):
        assert result.error_mean_percent <= 1.0
        assert result.error_p95_percent <= 2.1
    assert acknowledged.kbps <= 5.85


@pytest.mark.parametrize(
    ("profile", "kbps", "error"), [(NARROWBAND, 2.4, 1.2), (RICH, 11.0, 0.8)], ids=["narrow", "rich"]
)
def test_narrow_and_rich_keep_their_rate_and_error(
    tracks: dict[float, list[Track]], profile: Profile, kbps: float, error: float
) -> None:
    result = run(tracks, profile, Link(ack_delay=8))
    assert result.kbps <= kbps
    assert result.error_mean_percent <= error


def test_losses_hardly_change_the_error_of_the_other_frames(tracks: dict[float, list[Track]]) -> None:
    lossless, lossy = run(tracks, LIVE, Link(ack_delay=3)), run(tracks, LIVE, Link(ack_delay=3, loss=0.3, seed=1))
    assert 0.2 < lossy.frames_lost / lossy.frames < 0.4
    assert len(lossy.errors) == lossy.frames - lossy.frames_lost
    assert lossy.error_mean_percent < 1.5 * lossless.error_mean_percent


def test_json_has_exactly_the_documented_keys(shared: Path) -> None:
    command = [sys.executable, str(TOOL), str(shared / "motion" / "man_smiles.npz"), "--json", "--loss", "0.1"]
    printed = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    keys = {
        "payload_bytes_per_frame", "wire_bytes_per_frame", "kbps", "error_mean_percent", "error_p95_percent",
        "frames_played", "frames_lost", "frames_recovered", "encode_decode_ms",
    }  # fmt: skip
    assert set(printed) == {"overall", "tracks"}
    assert set(printed["overall"]) == set(printed["tracks"]["man_smiles"]) == keys
