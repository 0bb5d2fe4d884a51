"""`conf models`: download the tracker's files."""

import argparse

from conf.commands import Terminal

HELP = "the tracker's files"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("what", choices=["fetch", "path"], help="download them now, or print their folder")


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    from conf.sender.tracking.model_files import fetch_demo_clip, fetch_models, model_folder

    if options.what == "path":
        terminal.write(str(model_folder()))
        return
    fetch_models(terminal.write)
    fetch_demo_clip(terminal.write)
    terminal.write(f"the tracker's files are in {model_folder()}")
