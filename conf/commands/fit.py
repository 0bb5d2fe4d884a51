"""`conf fit`: find the control points of any face mesh."""

import argparse
from pathlib import Path

from conf.atomic_write import check_writable
from conf.commands import Terminal
from conf.commands.support.arguments import AXES, add_json

HELP = "find the control points of any face mesh"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("face", type=Path, metavar="FACE.obj", help="a mesh: OBJ, PLY, GLB, VRM or STL")
    parser.add_argument("-o", "--output", type=Path, metavar="FACE.ppc", help="default: beside the mesh")
    parser.add_argument(
        "--picture", type=Path, metavar="FACE.png", help="draw the face neutral, blinking, with open mouth and smiling"
    )
    parser.add_argument("--up", choices=AXES, help="the mesh's axis towards the crown (default: found by trying)")
    parser.add_argument("--front", choices=AXES, help="the mesh's axis towards the nose")
    add_json(parser)


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    from conf.mesh_fitting.expression_sheet import draw_fitted_face
    from conf.mesh_fitting.fit import fit
    from conf.output.image_writer import save_image

    if options.picture:
        _check_picture(options.picture)
    output = options.output or options.face.with_suffix(".ppc")
    with terminal.status_line() as show:
        report = fit(
            options.face, output, up=options.up, front=options.front,
            on_progress=lambda fraction, text: show(f"{text} ({fraction:.0%})"),
        )  # fmt: skip
        if options.picture:
            show("drawing the face")
            save_image(options.picture, draw_fitted_face(options.face, output))
    terminal.print_figures("fitted", report)
    if options.picture:
        terminal.write(f"saved {options.picture.absolute()}: check the drawings")


def _check_picture(path: Path) -> None:
    """Raise ConfError unless the suffix is that of an image and the file can be written."""
    from conf.errors import ConfError
    from conf.output.image_writer import IMAGE_FORMATS

    if path.suffix.lower() not in IMAGE_FORMATS:
        raise ConfError(f"{path}: the name must end in one of {', '.join(IMAGE_FORMATS)}")
    check_writable(path)
