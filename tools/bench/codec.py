"""Measure rate, error and speed of the motion codec: bytes a frame, kbit/s with headers, errors, losses, time.

    python tools/bench/codec.py TRACK.npz... [--profile live] [--ack-delay 2] [--loss 0.1] [--seed 0] [--json]

Without a track, the tracks held out of the training of the shipped tables. tools/bench/codec_link.py defines the error.
"""

import argparse
import json
import os
import sys
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from conf.errors import ConfError
from conf.protocol.codec.profiles import PROFILES
from tools.bench.codec_link import HELD_OUT, Link, Result, measure, total
from tools.bench.tracks import TrackReader

MOTION = Path(__file__).resolve().parents[3] / "shared" / "motion"
COLUMNS = {
    "payload_bytes_per_frame": "payload B",
    "wire_bytes_per_frame": "wire B",
    "kbps": "kbit/s",
    "error_mean_percent": "mean %",
    "error_p95_percent": "95th %",
    "frames_played": "played",
    "frames_lost": "lost",
    "frames_recovered": "recovered",
    "encode_decode_ms": "ms",
}


def main() -> None:
    """Print the table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("tracks", nargs="*", type=Path, metavar="TRACK.npz")
    parser.add_argument("--profile", choices=PROFILES, default="live")
    parser.add_argument("--ack-delay", type=int, default=2, help="frames until a frame is acknowledged; 0: never")
    parser.add_argument("--loss", type=float, default=0.0, help="loss probability of datagrams and of acknowledgements")
    parser.add_argument("--seed", type=int, default=0, help="random seed of the losses")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    if arguments.ack_delay < 0 or not 0 <= arguments.loss < 1:
        parser.error("--ack-delay must be at least 0; --loss must be at least 0 and below 1")
    profile = PROFILES[arguments.profile]
    link = Link(ack_delay=arguments.ack_delay, loss=arguments.loss, seed=arguments.seed)
    paths = arguments.tracks or [MOTION / f"{name}.npz" for name in HELD_OUT]
    try:
        reader = TrackReader()
        results = {path.stem: measure(reader.read(path, fps=profile.fps), profile, link) for path in paths}
    except (OSError, ConfError) as error:
        sys.exit(str(error))
    overall = total(list(results.values()))
    if arguments.json:
        tracks = {name: result.summary() for name, result in results.items()}
        print(json.dumps({"overall": overall.summary(), "tracks": tracks}, indent=2))
    else:
        bundling = f"{profile.frames_per_datagram} frames a datagram, {profile.delay * 1000:.0f} ms added"
        print(f"{profile.name}: {profile.fps} fps, {bundling}")
        _print_table({**results, "overall": overall})


def _print_table(results: dict[str, Result]) -> None:
    print(f"{'track':24}" + "".join(f"{title:>11}" for title in COLUMNS.values()))
    for name, result in results.items():
        summary = result.summary()
        print(f"{name:24}" + "".join(_cell(summary[key]) for key in COLUMNS))


def _cell(value: float) -> str:
    return f"{value:11d}" if isinstance(value, int) else f"{value:11.3f}"


if __name__ == "__main__":
    main()
