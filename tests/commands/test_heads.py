"""`conf heads`: the list, the drawing, and what is no image."""

import json
from pathlib import Path

import pytest

from conf.cli import main
from conf.face.head_catalogue import HEADS


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[object, str]:
    with pytest.raises(SystemExit) as exit_:
        main(["heads", *arguments])
    return exit_.value.code, capsys.readouterr().out


def test_heads_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    code, printed = run(capsys)
    lines = printed.splitlines()
    assert code == 0 and len(lines) == len(HEADS)
    assert lines[0].split(maxsplit=1) == [HEADS[0].name, HEADS[0].about]


def test_json_has_every_head_and_the_image(capsys: pytest.CaptureFixture[str]) -> None:
    code, printed = run(capsys, "--json")
    report = json.loads(printed)
    assert code == 0 and report["image"] is None
    assert report["heads"][1] == {"number": HEADS[1].number, "name": HEADS[1].name, "about": HEADS[1].about}


@pytest.mark.slow
def test_the_heads_are_drawn_into_a_file(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    image = tmp_path / "heads.png"
    code, printed = run(capsys, "-o", str(image))
    assert code == 0 and printed.splitlines()[-1] == f"saved {image}"
    assert image.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_a_file_that_is_no_image_is_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    output = tmp_path / "heads.txt"
    assert run(capsys, "-o", str(output))[0] == f"conf: {output} is no image: give a name that ends in .png or .jpg"
