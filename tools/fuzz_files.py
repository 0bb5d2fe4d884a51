"""Read mutated files of every format that conf reads, and count what happens.

    python tools/fuzz_files.py [--cases 200000] [--seed 1] [--only obj,mp4] [--json]

For each case a small valid file is mutated (bits, bytes, numbers, lines, values of JSON, truncation) and read as the
program reads it. A reader must return data or raise one of the program's errors with a message. Counted: data, errors,
other exceptions, killed processes, cases over 5 s, peak memory. Cases run in a worker process that is replaced when it
dies. A case is known by its format, seed and number, and is written beside the temporary folder if it fails. Exit
status 1 if anything but data or an error was seen.
"""

import argparse
import copy
import json
import multiprocessing
import random
import resource
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from conf.errors import ConfError
from conf.face.formats.dpc import MotionClip, read_dpc, write_dpc
from conf.face.formats.epc import read_epc
from conf.face.formats.ppc import read_ppc
from conf.face.mesh.mesh import load_mesh
from conf.sender.capture.clip import open_clip, read_sound

LIMIT_S = 5.0  # of CPU time: other load on the machine does not count
NO_ANSWER_S = 120.0  # after this a case hangs
BATCH = 500
FRAMES = 12  # frames of a clip that are read
ASSETS = Path(__file__).resolve().parents[1] / "conf" / "assets"
NUMBERS = (b"nan", b"inf", b"-1", b"0", b"1e999", b"99999999999", b"2147483648", b"-0", b"", b"1/2/3/4", b"x")
INTEGERS = (0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)


@dataclass
class Outcome:
    """What the cases of one format came to."""

    cases: int = 0
    data: int = 0
    errors: int = 0
    exceptions: int = 0
    killed: int = 0
    too_slow: int = 0
    slowest_s: float = 0.0
    peak_mb: float = 0.0
    examples: list[str] = field(default_factory=list)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=200_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="formats, separated by commas")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        samples = make_samples(folder)
        kinds = options.only.split(",") if options.only else list(samples)
        shares = {kind: SHARES.get(kind, 1.0) for kind in kinds}
        outcomes = {
            kind: fuzz(
                kind, samples[kind], round(options.cases * shares[kind] / sum(shares.values())), options.seed, folder
            )
            for kind in kinds
        }
    if options.json:
        print(json.dumps({kind: asdict(outcome) for kind, outcome in outcomes.items()}))
    else:
        print(table(outcomes))
    sys.exit(any(o.exceptions or o.killed or o.too_slow for o in outcomes.values()))


SHARES = {"avi": 0.5, "mp4": 0.5, "mkv": 0.5, "ts": 0.5}  # clips take longest


def fuzz(kind: str, sample: bytes, cases: int, seed: int, folder: Path) -> Outcome:
    """Run the cases of a format in worker processes, BATCH at a time."""
    outcome = Outcome()
    context = multiprocessing.get_context("fork")
    case = 0
    while case < cases:
        results, child = context.Pipe(duplex=False)
        last = min(case + BATCH, cases)
        worker = context.Process(target=run_cases, args=(kind, sample, range(case, last), seed, folder, child))
        worker.start()
        child.close()
        while case < last:
            if not results.poll(NO_ANSWER_S):
                worker.kill()
                outcome.too_slow += 1
                outcome.examples.append(f"{kind} {seed} {case}: no answer in {NO_ANSWER_S:.0f} s")
                case += 1
                break
            try:
                result = results.recv()
            except EOFError:
                outcome.killed += 1
                outcome.examples.append(f"{kind} {seed} {case}: killed")
                case += 1
                break
            note(outcome, result, f"{kind} {seed} {case}")
            case += 1
        outcome.cases = case
        worker.join()
    return outcome


def note(outcome: Outcome, result: tuple[str, float, float], case: str) -> None:
    """Add the result of one case: how it ended, seconds, peak memory in MB."""
    ending, seconds, memory = result
    outcome.data += ending == "data"
    outcome.errors += ending == "error"
    if ending not in ("data", "error"):
        outcome.exceptions += 1
        outcome.examples.append(f"{case}: {ending}")
    if seconds > LIMIT_S:
        outcome.too_slow += 1
        outcome.examples.append(f"{case}: {seconds:.1f} s")
    outcome.slowest_s = max(outcome.slowest_s, seconds)
    outcome.peak_mb = max(outcome.peak_mb, memory)


def run_cases(kind: str, sample: bytes, cases: range, seed: int, folder: Path, results: Any) -> None:
    """Mutate and read, in a process of its own."""
    read = READERS[kind]
    # The readers of meshes may look for files beside the mesh, so each worker has its own folder with an MTL.
    own = Path(tempfile.mkdtemp(dir=folder))
    (own / "head.mtl").write_bytes((ASSETS / "head" / "head.mtl").read_bytes())
    suffix = "obj" if kind == "mtl" else kind
    path = own / f"case.{suffix}"
    for case in cases:  # a case depends on its number alone
        rng = random.Random(f"{kind} {seed} {case}")
        if kind in GLTFS and rng.random() < 0.6:
            data = mutate_gltf(sample, rng)
        else:
            data = mutate(sample, rng, text=kind in TEXTS)
        if kind == "mtl":
            (own / "head.mtl").write_bytes(data)
            data = b"mtllib head.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
        path.write_bytes(data)
        start = time.process_time()
        try:
            read(path)
            ending = "data"
        except ConfError as error:
            ending = "error" if str(error) else "an error without a message"
        except Exception as error:
            ending = f"{type(error).__name__}: {error}"[:200]
            (folder.parent / f"fuzz-{kind}-{seed}-{case}.{kind}").write_bytes(data)
        seconds = time.process_time() - start
        results.send((ending, seconds, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024))
    results.close()


def mutate(sample: bytes, rng: random.Random, *, text: bool) -> bytes:
    """Return a damaged copy, most often damaged a little."""
    data = bytearray(sample)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 8))):
        if not data:
            break
        rng.choice(TEXT_MUTATIONS if text and rng.random() < 0.7 else BYTE_MUTATIONS)(data, rng)
    return bytes(data)


def mutate_gltf(sample: bytes, rng: random.Random) -> bytes:
    """Return a glTF or GLB file of which some values of the JSON are changed, removed or copied."""
    is_binary = sample[:4] == b"glTF"
    size = int.from_bytes(sample[12:16], "little")
    header = json.loads(sample[20 : 20 + size] if is_binary else sample)
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        container, key = rng.choice(list(_entries(header)))
        match rng.randrange(6):
            case 0:
                del container[key]
            case 1:
                other, name = rng.choice(list(_entries(header)))
                container[key] = copy.deepcopy(other[name])
            case _:
                container[key] = copy.deepcopy(rng.choice(JSON_VALUES))
    text = json.dumps(header).encode()
    if not is_binary:
        return text
    text += b" " * (-len(text) % 4)
    rest = len(text).to_bytes(4, "little") + b"JSON" + text + sample[20 + size :]
    return sample[:8] + (12 + len(rest)).to_bytes(4, "little") + rest


def _entries(value: Any) -> Iterator[tuple[Any, Any]]:
    """Yield each list or object inside a JSON value with each of its indices or keys."""
    keys = list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    for key in keys:
        yield value, key
        yield from _entries(value[key])


def _flip(data: bytearray, rng: random.Random) -> None:
    data[_near_start(data, rng)] ^= 1 << rng.randrange(8)


def _set_integer(data: bytearray, rng: random.Random) -> None:
    at, size = _near_start(data, rng), rng.choice((1, 2, 4, 8))
    data[at : at + size] = (rng.choice(INTEGERS) & (256**size - 1)).to_bytes(size, rng.choice(("little", "big")))


def _truncate(data: bytearray, rng: random.Random) -> None:
    del data[rng.randrange(len(data)) :]


def _delete(data: bytearray, rng: random.Random) -> None:
    at = rng.randrange(len(data))
    del data[at : at + rng.choice((1, 4, 100))]


def _repeat(data: bytearray, rng: random.Random) -> None:
    at = rng.randrange(len(data))
    piece = data[at : at + rng.choice((1, 16, 500))]
    data[at:at] = piece * rng.choice((1, 2, 50))


def _noise(data: bytearray, rng: random.Random) -> None:
    at = rng.randrange(len(data))
    data[at : at + 8] = rng.randbytes(8)


def _number(data: bytearray, rng: random.Random) -> None:
    words = [bytes(word) for word in data.split(b" ")]
    words[rng.randrange(len(words))] = rng.choice(NUMBERS)
    data[:] = b" ".join(words)


def _lines(data: bytearray, rng: random.Random) -> None:
    lines = [bytes(line) for line in data.split(b"\n")]
    a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
    match rng.randrange(4):
        case 0:
            lines[a], lines[b] = lines[b], lines[a]
        case 1:
            del lines[a]
        case 2:
            lines.insert(a, lines[b] * 2)
        case _:
            lines[a] = rng.choice((b"\xef\xbb\xbf", b"\x1a", b"# ", b"\t")) + lines[a]
    data[:] = b"\n".join(lines)


def _near_start(data: bytearray, rng: random.Random) -> int:
    """Return a position, in half of all cases in the first 500 bytes: headers are where readers are deceived."""
    return rng.randrange(min(len(data), 500) if rng.random() < 0.5 else len(data))


JSON_VALUES: tuple[Any, ...] = (
    *(0, 1, 2, 3, -1, 5, 255, 5120, 5121, 5123, 5125, 5126, 2**31, 10**12, 0.5, -2.5, 1e300, float("nan")),
    *("", "x", "SCALAR", "VEC2", "VEC3", "MAT4", "MASK", "gone.png", "data:;base64,AAAA", None, True, [], {}),
    *([1e9, 0, 0], [0, 0, 0, 0], {"index": 0}, {"count": 3}, {"KHR_texture_transform": {"scale": [2, 0]}}),
)
BYTE_MUTATIONS = (_flip, _flip, _set_integer, _truncate, _delete, _repeat, _noise)
TEXT_MUTATIONS = (_number, _number, _lines)


def _read_clip(path: Path) -> None:
    with open_clip(path) as clip:
        for _ in range(FRAMES):
            if clip.read() is None:
                break
    for count, _ in enumerate(read_sound(path)):
        if count == FRAMES:
            break


READERS: dict[str, Callable[[Path], object]] = {
    "obj": load_mesh, "mtl": load_mesh, "ply": load_mesh, "glb": load_mesh, "stl": load_mesh,
    "gltf": load_mesh, "vrm": load_mesh,
    "ppc": read_ppc, "dpc": read_dpc, "epc": read_epc,
    "avi": _read_clip, "mp4": _read_clip, "mkv": _read_clip, "ts": _read_clip,
}  # fmt: skip
GLTFS = {"glb", "vrm", "gltf"}
TEXTS = {"obj", "mtl", "gltf", "ppc", "dpc", "epc"}


def make_samples(folder: Path) -> dict[str, bytes]:
    """Return one small valid file of each format."""
    gltf: Any = trimesh.exchange.gltf
    ball = trimesh.creation.icosphere(subdivisions=2)
    lines = [f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in ball.vertices]
    lines += [f"vt {x:.3f} {y:.3f}" for x, y, _ in ball.vertices]
    lines += ["mtllib head.mtl", "g skin", "usemtl face"]
    lines += [f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in ball.faces + 1]
    samples = {"obj": "\n".join(lines).encode(), "mtl": (ASSETS / "head" / "head.mtl").read_bytes()}
    samples |= {kind: ball.export(file_type=kind) for kind in ("ply", "glb", "stl")}
    ball.visual = textured(ball)
    samples["vrm"] = ball.export(file_type="glb")
    samples["gltf"] = gltf.export_gltf(ball.scene(), embed_buffers=True)["model.gltf"]
    samples["ppc"] = (ASSETS / "head" / "head.ppc").read_bytes()
    samples["epc"] = (ASSETS / "emotions" / "joy.epc").read_bytes()
    rng = np.random.default_rng(1)
    motion = MotionClip(25.0, "fapu", rng.normal(0, 100, (4, 50, 3)).astype(np.float32), rng.normal(0, 0.1, (4, 6)))
    write_dpc(folder / "sample.dpc", motion)
    samples["dpc"] = (folder / "sample.dpc").read_bytes()
    for kind, codec in (("avi", "mjpeg"), ("mp4", "mpeg4"), ("mkv", "libx264"), ("ts", "mpeg2video")):
        samples[kind] = make_clip(folder / f"sample.{kind}", codec)
    return samples


def textured(mesh: Any) -> Any:
    """Return texture coordinates and a material with an image for a mesh of trimesh."""
    visual: Any = trimesh.visual
    image = Image.fromarray(np.arange(8 * 8 * 4, dtype=np.uint8).reshape(8, 8, 4))
    material = visual.material.PBRMaterial(
        baseColorTexture=image, baseColorFactor=[0.9, 0.5, 0.4, 1.0], alphaMode="BLEND"
    )
    return visual.TextureVisuals(uv=(mesh.vertices[:, :2] + 1) / 2, material=material)


def make_clip(path: Path, codec: str) -> bytes:
    """Return a clip of half a second with a picture and a tone."""
    import av

    with av.open(str(path), "w") as container:
        video: Any = container.add_stream(codec, rate=25)
        video.width, video.height, video.pix_fmt = 64, 48, "yuvj420p" if codec == "mjpeg" else "yuv420p"
        sound: Any = container.add_stream("mp2" if path.suffix in (".avi", ".ts") else "aac", rate=48000)
        for i in range(FRAMES):
            pixels = np.full((48, 64, 3), 20 * i, np.uint8)
            frame = av.VideoFrame.from_ndarray(pixels, format="bgr24").reformat(format=video.pix_fmt)
            frame.pts, frame.time_base = i, Fraction(1, 25)
            container.mux(video.encode(frame))
        tone = (8000 * np.sin(np.arange(24000) / 17)).astype(np.int16)
        format_ = sound.codec_context.format.name
        for start in range(0, len(tone), 1152):
            block = av.AudioFrame.from_ndarray(tone[None, start : start + 1152], format="s16", layout="mono")
            block.sample_rate, block.pts, block.time_base = 48000, start, Fraction(1, 48000)
            resampler = av.AudioResampler(format=format_, layout=sound.codec_context.layout.name, rate=48000)
            for resampled in resampler.resample(block):
                container.mux(sound.encode(resampled))
        container.mux(video.encode())
        container.mux(sound.encode())
    return path.read_bytes()


def table(outcomes: dict[str, Outcome]) -> str:
    """Return one line a format, the total, and examples of what failed."""
    counts: Counter[str] = Counter()
    lines = ["format    cases     data   errors  other  killed  slow  slowest s  peak MB"]
    for kind, o in outcomes.items():
        lines.append(
            f"{kind:6} {o.cases:8} {o.data:8} {o.errors:8} {o.exceptions:6} {o.killed:7} {o.too_slow:5} "
            f"{o.slowest_s:10.2f} {o.peak_mb:8.0f}"
        )
        counts.update(cases=o.cases, exceptions=o.exceptions, killed=o.killed, slow=o.too_slow)
    lines.append(", ".join(f"{name} {count}" for name, count in counts.items()))
    return "\n".join([*lines, *(text for o in outcomes.values() for text in o.examples[:10])])


if __name__ == "__main__":
    main()
