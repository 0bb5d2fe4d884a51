from pathlib import Path

import cv2
import numpy as np
import pytest

from conf.audio.samples import SAMPLE_RATE
from conf.cli import main
from conf.commands.measure import StageCost, measure, plot
from conf.errors import CameraError
from conf.output.video_writer import VideoWriter
from conf.sender.capture.clip import open_clip
from tests.support.synthetic_voice import speech


@pytest.mark.slow
def test_later_stages_are_smaller_and_ratios_are_consistent(short_clip: Path) -> None:
    stages = measure(short_clip)
    raw, *_, coded, sealed, wire = stages
    assert raw == StageCost("raw pixels 386x288", 386 * 288 * 3, raw.fps, raw.kbps, 1.0)
    assert raw.fps == pytest.approx(15.0)
    assert coded.bytes_per_frame < sealed.bytes_per_frame < wire.bytes_per_frame < 150
    for stage in stages:
        assert stage.ratio == pytest.approx(raw.bytes_per_frame / stage.bytes_per_frame)
        assert stage.kbps == pytest.approx(stage.bytes_per_frame * stage.fps * 8 / 1000)


@pytest.mark.slow
def test_a_clip_with_sound_has_stages_for_the_voice(short_clip: Path, tmp_path: Path) -> None:
    """The clip is played forwards and backwards, and somebody speaks in it."""
    path, sound = tmp_path / "talk.mp4", speech(4.0)
    with open_clip(short_clip) as clip:
        frames = [np.asarray(frame.pixels, np.uint8) for frame in iter(clip.read, None)]
    with VideoWriter(path, fps=30.0, audio_rate=SAMPLE_RATE) as writer:
        for number in range(120):
            writer.write(frames[(number if number // 24 % 2 == 0 else -1 - number) % 24])
        writer.write_audio(sound, 0.0)
    silent, stages = measure(short_clip), {stage.name: stage for stage in measure(path)}
    assert list(stages)[: len(silent)] == [stage.name for stage in silent]
    pcm, rtp, both = list(stages.values())[len(silent) :]
    assert (pcm.name, pcm.kbps, pcm.ratio) == ("sound, PCM 16 kHz", 256.0, 1.0)
    assert (rtp.name, rtp.kbps) == ("voice, Opus 6000 in RTP, 20 ms", pytest.approx(22.0, abs=1.0))
    assert rtp.ratio == pytest.approx(256 / rtp.kbps)
    assert both.name == "face and voice, one datagram"
    assert stages["with UDP/IP headers"].kbps < both.kbps <= 16.0
    raw = stages["raw pixels 386x288"]
    assert both.ratio == pytest.approx((raw.bytes_per_frame + pcm.bytes_per_frame) / both.bytes_per_frame)
    for stage in (pcm, rtp, both):
        assert stage.kbps == pytest.approx(stage.bytes_per_frame * raw.fps * 8 / 1000)


@pytest.mark.slow
def test_a_clip_without_a_face_is_an_error(empty_clip: Path) -> None:
    with pytest.raises(CameraError, match="shows no face"):
        measure(empty_clip)


@pytest.mark.slow
def test_the_plot_is_an_image(gl: None, tmp_path: Path) -> None:
    stages = [StageCost("raw pixels", 76_032.0, 15.0, 9123.8, 1.0), StageCost("coded", 20.0, 15.0, 2.4, 3801.6)]
    plot(stages, tmp_path / "plot.png")
    image = cv2.imread(str(tmp_path / "plot.png"))
    assert image is not None and image.std() > 5


def test_a_plot_that_cannot_be_written_is_an_error_before_the_clip_is_read(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match=r"plot\.png cannot be written \(No such file or directory\); choose another"):
        main(["measure", "no.mp4", "--plot", str(tmp_path / "none" / "plot.png")])
