"""The command line: the only module that parses arguments, prints and exits.

Exit status: 0 done, 1 one clear line on stderr, 2 usage. With --json a command prints one JSON object and nothing else.
"""

import argparse
import json
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from conf.errors import ConfError

DEFAULT_HOST = "127.0.0.1"
DEFAULT_PORT = 5005
HEADLESS_SECONDS = 20.0
PORTRAIT_KBPS = 3.0  # below this cap the motion alone fills it
AXES = ("x", "-x", "y", "-y", "z", "-z")
PROFILES_HELP = "live: 15 frames a second; narrow: for 2,400 bit/s; rich: 30; auto: live, and less when the link asks"


def main(arguments: list[str] | None = None) -> None:
    """Run one command and exit."""
    for pool in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ.setdefault(pool, "1")  # before numpy: two BLAS pools, or one beside the renderer, cost milliseconds
    options = build_parser().parse_args(arguments)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        options.run(options)
    except ConfError as error:
        sys.exit(f"conf: {error}")
    except KeyboardInterrupt:
        sys.exit(130)
    except BrokenPipeError:
        with suppress(OSError):
            sys.stdout.close()
        sys.exit(1)
    except Exception as error:
        if os.environ.get("CONF_DEBUG"):
            raise
        sys.exit(f"conf: {type(error).__name__}: {error} (this is a fault of conf; CONF_DEBUG=1 shows where)")
    sys.exit(0)


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of all commands; each sets `run` to the function that carries it out."""
    parser = argparse.ArgumentParser(prog="conf", description="A video conference for links that cannot carry video.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(name: str, run: Callable[[argparse.Namespace], None], text: str) -> argparse.ArgumentParser:
        sub = commands.add_parser(name, help=text, description=text)
        sub.set_defaults(run=run)
        return sub

    demo = command("demo", _demo, "a call on this machine: the sample clip, real UDP, a window with the meter")
    demo.add_argument("--seconds", type=_positive, help="stop after so long (without a display: 20)")
    demo.add_argument("--headless", action="store_true", help="no window: write conf-demo.avi and conf-demo.jpg")

    receive = command("receive", _receive, "listen, and show who calls")
    receive.add_argument(
        "--listen",
        type=_address,
        default=(DEFAULT_HOST, DEFAULT_PORT),
        metavar="HOST:PORT",
        help=f"default {DEFAULT_HOST}:{DEFAULT_PORT}; 0.0.0.0:{DEFAULT_PORT} takes calls from the network",
    )
    receive.add_argument("--code", type=_code, help="the code callers must know (default: a new one each time)")
    receive.add_argument("--face", type=Path, metavar="FILE", help="another face: a mesh with its PPC beside it")
    receive.add_argument("--headless", type=Path, metavar="OUT.avi", help="no window: draw into this clip")
    receive.add_argument("--seconds", type=_positive, help="stop after so long")

    send = command("send", _send, "track a face and send its motion")
    send.add_argument("receiver", type=_address, metavar="HOST[:PORT]")
    source = send.add_mutually_exclusive_group()
    source.add_argument("--camera", default="0", metavar="N", help="number or device of the camera (default 0)")
    source.add_argument("--file", type=Path, metavar="CLIP", help="a clip as the camera")
    source.add_argument("--dpc", type=Path, metavar="FILE", help="a recorded motion instead of a face")
    send.add_argument("--code", type=_code, help="the code the receiver shows (default: CONF_CODE, or asked for)")
    send.add_argument("--profile", choices=["auto", "live", "narrow", "rich"], default="auto", help=PROFILES_HELP)
    send.add_argument("--kbps", type=_positive, metavar="N", help="never more than this over any ten seconds")
    send.add_argument("--calibrate", action="store_true", help="take the first face seen for the neutral one")
    send.add_argument("--preview", action="store_true", help="a window with what the camera sees; N: this is neutral")
    send.add_argument("--portrait", action="store_true", help="let pictures of the person be sent (default: none ever)")
    send.add_argument(
        "--portrait-kbps", type=_positive, default=4.0, metavar="N", help="what they may cost (default 4)"
    )
    send.add_argument("--loop", action="store_true", help="play the clip again and again")
    send.add_argument("--seconds", type=_positive, help="stop after so long")

    extract = command("extract", _extract, "write the motion of a clip as a DPC file")
    extract.add_argument("clip", type=Path)
    extract.add_argument("-o", "--output", type=Path, required=True, metavar="OUT.dpc")

    animate = command("animate", _animate, "a window to move a face by hand, by emotions, muscles or recordings")
    animate.add_argument("face", type=Path, nargs="?", metavar="FACE.obj", help="default: the head that comes along")
    animate.add_argument("--ppc", type=Path, help="its control points (default: the PPC file beside it, or found)")
    animate.add_argument("--up", choices=AXES, help="the mesh's axis towards the crown, while it has no points")
    animate.add_argument("--front", choices=AXES, help="the mesh's axis towards the nose")
    animate.add_argument("--dpc", type=Path, help="play this recording")
    animate.add_argument("--emotion", metavar="NAME", help="show an emotion: joy, surprise, doubt, ... or an EPC file")

    export = command("export", _export, "draw a recording or an emotion into a picture, clip or other format")
    what = export.add_mutually_exclusive_group(required=True)
    what.add_argument("--dpc", type=Path, help="a recording")
    what.add_argument("--emotion", metavar="NAME", help="an emotion, or an EPC file")
    export.add_argument(
        "-o", "--output", type=Path, required=True, help="a .jpg .png .avi .mp4 .obj .dpc .fap or .csv file"
    )
    export.add_argument("--size", default="1280x720", metavar="WxH")
    export.add_argument("--fps", metavar="N", help="pictures a second")
    export.add_argument("--face", type=Path, metavar="FILE", help="another face: a mesh with its PPC beside it")
    export.add_argument("--ppc", type=Path, help="its control points, if they lie elsewhere")
    export.add_argument("--at", type=float, metavar="S", help="the moment of a single picture")

    fit = command("fit", _fit, "place the control points on any face mesh")
    fit.add_argument("face", type=Path, metavar="FACE.obj")
    fit.add_argument("-o", "--output", type=Path, metavar="FACE.ppc", help="default: beside the mesh")
    fit.add_argument("--up", choices=AXES, help="the mesh's axis towards the crown (default: found by trying)")
    fit.add_argument("--front", choices=AXES, help="the mesh's axis towards the nose")

    measure = command("measure", _measure, "bytes a frame of every stage beside raw pixels")
    measure.add_argument("clip", type=Path)
    measure.add_argument("--profile", choices=["live", "narrow", "rich"], default="live")
    measure.add_argument("--plot", type=Path, metavar="OUT.png", help="draw the table as bars")

    models = command("models", _models, "the tracker's files")
    models.add_argument("what", choices=["fetch", "path"], help="fetch them now, or say where they lie")

    doctor = command("doctor", _doctor, "what works on this machine, what does not, what to do")
    doctor.add_argument("--camera", default="0", metavar="N")
    doctor.add_argument("--listen", type=_address, default=(DEFAULT_HOST, DEFAULT_PORT), metavar="HOST:PORT")

    for sub in (demo, receive, send, extract, export, fit, measure, doctor):
        sub.add_argument("--json", action="store_true", help="print one JSON object and nothing else")
    return parser


def _positive(text: str) -> float:
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value


def _code(text: str) -> str:
    from conf.protocol.session.pairing_code import normalise_code

    try:
        return normalise_code(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def _address(text: str) -> tuple[str, int]:
    host, colon, port = text.rpartition(":")
    if not colon or (host.count(":") and not host.startswith("[")):
        host, port = text, str(DEFAULT_PORT)
    if not host or not port.isdigit() or not int(port) < 65536:
        raise argparse.ArgumentTypeError(f"{text} is not HOST:PORT")
    return host.strip("[]"), int(port)


def _demo(options: argparse.Namespace) -> None:
    from conf.commands.demo import demo
    from conf.commands.receive import has_display

    headless = options.headless or not has_display()
    seconds = options.seconds or (HEADLESS_SECONDS if headless else None)
    result = demo(seconds=seconds, headless=headless)
    _print_figures("the call", result.traffic, options)
    if result.clip and not options.json:
        print(f"wrote {result.clip} and {result.picture}")


def _receive(options: argparse.Namespace) -> None:
    from conf.commands.receive import ReceiveOptions, receive
    from conf.protocol.session.pairing_code import generate_code
    from conf.transport.udp import UdpSocket

    code = options.code or generate_code(os.urandom)
    with UdpSocket.bind(*options.listen) as link:
        _tell("listening on {}:{}, code {}".format(*link.address, code), options)
        showing = ReceiveOptions(options.headless, None, options.seconds, on_event=lambda text: _tell(text, options))
        traffic = receive(link, code, showing, face=options.face)
    _print_figures("the call", traffic, options)


def _send(options: argparse.Namespace) -> None:
    from conf.commands.send import SendOptions, send
    from conf.protocol.sender_connection import RateOptions

    code = options.code or _ask_code()
    link = RateOptions(options.profile, options.kbps)
    if options.portrait and (options.profile == "narrow" or (options.kbps or PORTRAIT_KBPS) < PORTRAIT_KBPS):
        _tell("no picture will be sent: --profile narrow and so low a --kbps leave no room for one", options)
    sending = SendOptions(
        options.camera,
        options.file,
        options.dpc,
        options.loop,
        options.seconds,
        calibrate=options.calibrate,
        preview=options.preview,
        portrait_kbps=options.portrait_kbps if options.portrait else None,
        link=link,
    )
    with _status_line(options) as show:
        status = send(options.receiver, code, sending, on_status=lambda s: show(_sender_line(s)))
    _print_figures("sent", status, options)


def _ask_code() -> str:
    """Return the code from CONF_CODE or from the user. Raises ConfError when there is neither."""
    text = os.environ.get("CONF_CODE")
    if not text and sys.stdin.isatty():
        text = input("the code that the receiver shows: ")
    try:
        return _code(text or "")
    except argparse.ArgumentTypeError as error:
        raise ConfError(f"{error}: give the one the receiver shows with --code") from error


def _sender_line(status: Any) -> str:
    link = status.link
    if not link.connected:
        return status.note or "calling"
    if link.stopped:
        return "nothing has come back for 10 s: not sending; trying now and then"
    parts = ["face" if status.face else "no face: looking for one", f"{link.profile}, {status.wire_kbps:.1f} kbit/s"]
    parts.append(f"{status.wire_bytes_per_frame:.0f} B a frame with headers, {status.frames_sent} frames")
    if link.round_trip_ms is not None:
        parts.append(f"round trip {link.round_trip_ms:.0f} ms, loss {link.loss_percent or 0:.1f} %")
        parts.append(f"jitter {link.jitter_ms or 0:.0f} ms")
    return ", ".join([*parts, f"tracker {status.tracker_ms_median:.1f} ms"])


def _extract(options: argparse.Namespace) -> None:
    from conf.commands.extract import extract

    with _status_line(options) as show:
        result = extract(options.clip, options.output, on_progress=lambda n: show(f"{n} frames"))
    _print_figures("extracted", result, options)


def _animate(options: argparse.Namespace) -> None:
    from conf.commands.animate import FaceOptions, animate

    sitter = FaceOptions(options.face, options.ppc, options.up, options.front)
    animate(sitter, dpc=options.dpc, emotion=options.emotion)


def _export(options: argparse.Namespace) -> None:
    from conf.commands.export import ExportRequest, export_file

    names = ("output", "dpc", "emotion", "size", "fps", "face", "ppc", "at")
    wish = ExportRequest(**{name: getattr(options, name) for name in names})
    with _progress(options) as show:
        result = export_file(wish, show)
    _print_figures("exported", result, options)


def _fit(options: argparse.Namespace) -> None:
    from conf.mesh_fitting.fit import fit

    output = options.output or options.face.with_suffix(".ppc")
    with _status_line(options) as show:
        result = fit(options.face, output, up=options.up, front=options.front, on_progress=show)
    _print_figures("fitted", result, options)


def _measure(options: argparse.Namespace) -> None:
    from conf.commands.measure import measure, plot

    with _status_line(options) as show:
        stages = measure(options.clip, options.profile, on_progress=lambda n: show(f"{n} frames"))
    if options.plot:
        plot(stages, options.plot)
    if options.json:
        print(json.dumps({"stages": [asdict(stage) for stage in stages]}))
        return
    from rich.console import Console
    from rich.table import Table

    table = Table("stage", "B a frame", "kbit/s", "raw : this")
    for stage in stages:
        table.add_row(stage.name, f"{stage.bytes_per_frame:,.1f}", f"{stage.kbps:,.1f}", f"{stage.ratio:,.0f}")
    Console().print(table)


def _models(options: argparse.Namespace) -> None:
    from conf.sender.tracking.model_files import fetch_demo_clip, fetch_models, model_folder

    if options.what == "path":
        print(model_folder())
        return
    fetch_models(print)
    fetch_demo_clip(print)
    print(f"the tracker's files are in {model_folder()}")


def _doctor(options: argparse.Namespace) -> None:
    from conf.commands.doctor import run_checks

    host, port = options.listen
    findings = run_checks(camera=options.camera, host=host, port=port)
    if options.json:
        print(json.dumps({"findings": [asdict(finding) for finding in findings]}))
        return
    for finding in findings:
        print(f"{'works' if finding.works else 'FAILS'}  {finding.name}: {finding.detail}")


def _print_figures(title: str, result: Any, options: argparse.Namespace) -> None:
    """Print a dataclass of figures, as one JSON object or as a table."""
    figures = asdict(result)
    if options.json:
        print(json.dumps({name: round(v, 3) if isinstance(v, float) else v for name, v in figures.items()}))
        return
    from rich.console import Console
    from rich.table import Table

    table = Table(title=title, show_header=False, title_justify="left")
    nested = [item for value in figures.values() if isinstance(value, dict) for item in value.items()]
    for name, value in [*figures.items(), *nested]:
        if not isinstance(value, dict):
            table.add_row(name.replace("_", " "), f"{value:,.1f}" if isinstance(value, float) else str(value))
    Console().print(table)


def _tell(text: str, options: argparse.Namespace) -> None:
    """Print a line for people; with --json it goes to stderr."""
    print(text, file=sys.stderr if options.json else sys.stdout, flush=True)


@contextmanager
def _progress(options: argparse.Namespace) -> Iterator[Callable[[float], None]]:
    """Show a bar, on stderr; nothing with --json. What it yields is told the share that is done."""
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True, disable=options.json) as progress:
        task = progress.add_task("writing", total=1.0)
        yield lambda share: progress.update(task, completed=share)


@contextmanager
def _status_line(options: argparse.Namespace) -> Iterator[Callable[[str], None]]:
    """Show a line that changes in place, on stderr; nothing with --json or without a terminal."""
    from rich.console import Console

    console = Console(stderr=True, quiet=options.json)
    with console.status("starting") as status:
        yield status.update
