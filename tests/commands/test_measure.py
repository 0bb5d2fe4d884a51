from pathlib import Path

import cv2
import pytest

from conf.cli import main
from conf.commands.measure import StageCost, measure, plot
from conf.errors import CameraError


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


def test_a_clip_without_a_face_is_an_error(empty_clip: Path) -> None:
    with pytest.raises(CameraError, match="shows no face"):
        measure(empty_clip)


def test_the_plot_is_an_image(gl: None, tmp_path: Path) -> None:
    stages = [StageCost("raw pixels", 76_032.0, 15.0, 9123.8, 1.0), StageCost("coded", 20.0, 15.0, 2.4, 3801.6)]
    plot(stages, tmp_path / "plot.png")
    image = cv2.imread(str(tmp_path / "plot.png"))
    assert image is not None and image.std() > 5


def test_a_plot_that_cannot_be_written_is_an_error_before_the_clip_is_read(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match=r"plot\.png cannot be written \(No such file or directory\); choose another"):
        main(["measure", "no.mp4", "--plot", str(tmp_path / "none" / "plot.png")])
