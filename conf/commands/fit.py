"""`conf fit`: find the control points of any face mesh."""

import argparse
from pathlib import Path

from conf.commands import Terminal
from conf.commands.arguments import AXES, add_json

HELP = "find the control points of any face mesh"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("face", type=Path, metavar="FACE.obj")
    parser.add_argument("-o", "--output", type=Path, metavar="FACE.ppc", help="default: beside the mesh")
    parser.add_argument("--up", choices=AXES, help="the mesh's axis towards the crown (default: found by trying)")
    parser.add_argument("--front", choices=AXES, help="the mesh's axis towards the nose")
    add_json(parser)


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    from conf.mesh_fitting.fit import fit

    output = options.output or options.face.with_suffix(".ppc")
    with terminal.status_line() as show:
        report = fit(options.face, output, up=options.up, front=options.front, on_progress=show)
    terminal.print_figures("fitted", report)
