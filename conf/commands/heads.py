"""`conf heads`: list and draw the heads that callers can choose."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

from conf.commands import Terminal
from conf.commands.support.arguments import add_json
from conf.errors import ConfError

HELP = "list and draw the heads to choose from with --head"
IMAGE_SUFFIXES = (".png", ".jpg")


@dataclass(frozen=True)
class HeadEntry:
    """One head. number : in messages between the ends of a call"""

    number: int
    name: str
    about: str


@dataclass(frozen=True)
class HeadsReport:
    """The heads, and the image that was written, None for none."""

    heads: tuple[HeadEntry, ...]
    image: str | None


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", type=Path, metavar="OUT.png", help="draw them into this image, PNG or JPG")
    add_json(parser)


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    from conf.face.head_catalogue import HEADS

    image = None if options.output is None else str(_draw(options.output))
    report = HeadsReport(tuple(HeadEntry(head.number, head.name, head.about) for head in HEADS), image)
    terminal.print_figures("heads", report, describe_heads(report))


def describe_heads(report: HeadsReport, /) -> str:
    """Return a line for each head, and one for the image."""
    width = max(len(head.name) for head in report.heads)
    lines = [f"{head.name:<{width}}  {head.about}" for head in report.heads]
    return "\n".join([*lines, *([f"saved {report.image}"] if report.image else [])])


def _draw(output: Path) -> Path:
    """Draw all heads into a file. Raises ConfError, GraphicsError, RecordingError."""
    from conf.face.head_catalogue import HEADS
    from conf.face.loading import load_head
    from conf.output.image_writer import save_image
    from conf.render.head_sheet import draw_heads

    if output.suffix.lower() not in IMAGE_SUFFIXES:
        raise ConfError(f"{output} is no image: give a name that ends in {' or '.join(IMAGE_SUFFIXES)}")
    return save_image(output, draw_heads({head.name: load_head(head) for head in HEADS}))
