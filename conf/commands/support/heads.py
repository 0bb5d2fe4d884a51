"""The options about drawn heads, and what their values mean."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from conf.errors import ConfError

if TYPE_CHECKING:
    from conf.receiver.heads.loader import HeadLoader


def add_head(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--head", metavar="NAME", help="the head that you are drawn with, one of `conf heads` (default: a free one)"
    )


def add_proportions(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--no-proportions",
        action="store_true",
        help="draw every head as it is, not with the proportions of its person's face",
    )


def head_number(name: str | None, /) -> int:
    """Return the number of a head by its name, 0 for None. Raises ConfError for an unknown name."""
    from conf.face.head_catalogue import HEADS_BY_NAME

    if name is None:
        return 0
    head = HEADS_BY_NAME.get(name.strip().lower())
    if head is None:
        raise ConfError(f"there is no head {name!r}: choose one of {', '.join(HEADS_BY_NAME)}")
    return head.number


def head_loader(face: object | None, /) -> HeadLoader | None:
    """Return what loads heads other than the default one; None if all are drawn with one face. face : it, or None"""
    from conf.receiver.heads.loader import HeadLoader

    return None if face is not None else HeadLoader()
