"""A second decoder, written from WIRE.md alone: it imports nothing of conf. Slow, simple, in integers."""

from dataclasses import dataclass, field
from math import ceil, floor, log2
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
from numpy.typing import NDArray

ASSETS = Path(__file__).resolve().parents[2] / "conf" / "assets"
PROFILES = ("live", "rich", "narrow", "voice", "slow")
STEPS = {"live": 0.0094, "rich": 0.006, "narrow": 0.0136, "voice": 0.0094, "slow": 0.015}
TABLES = {"live": "live", "rich": "rich", "narrow": "narrow", "voice": "live", "slow": "narrow"}
COUNTS = {"live": (1,), "rich": (2,), "narrow": (3,), "voice": (1, 2), "slow": (3, 6)}
TOTAL = 1 << 15


def uniform(size: int) -> list[int]:
    """Return the cumulative frequencies of equally likely symbols."""
    return [TOTAL * i // size for i in range(size + 1)]


def weighted(weights: list[float]) -> list[int]:
    """Return cumulative frequencies proportional to weights."""
    parts = [1 + floor((TOTAL - len(weights)) * w / sum(weights)) for w in weights]
    parts[0] += TOTAL - sum(parts)
    return [sum(parts[:i]) for i in range(len(parts) + 1)]


class Range:
    """The interval of the range coder, in integers of any length."""

    def __init__(self, payload: bytes) -> None:
        self.payload = payload
        self.low, self.width, self.bits = 0, 1 << 32, 32

    def symbol(self, table: list[int]) -> int:
        """Read one symbol."""
        step = self.width >> 15
        number = int.from_bytes(self.payload.ljust(self.bits // 8, b"\0")[: self.bits // 8])
        target = min((number - self.low) // step, TOTAL - 1)
        symbol = max(s for s in range(len(table) - 1) if table[s] <= target)
        self.low += step * table[symbol]
        self.width = step * (table[symbol + 1] - table[symbol])
        while self.width < 1 << 32:
            self.low, self.width, self.bits = self.low << 16, self.width << 16, self.bits + 16
        return symbol

    def bits_of(self, count: int) -> int:
        """Read raw bits, at most eight at a time, high ones first."""
        value = 0
        while count:
            part = min(8, count)
            value, count = value << part | self.symbol(uniform(1 << part)), count - part
        return value

    def end(self) -> bytes:
        """Return the string that the writer would have written."""
        if self.low == 0:
            return b""
        size = max(256**k for k in range(self.bits // 8 + 1) if -(-self.low // 256**k) * 256**k < self.low + self.width)
        return (-(-self.low // size) * size).to_bytes(self.bits // 8).rstrip(b"\0")


def read_number(string: Range, tables: list[list[int]], scale: int) -> int:
    """Read a number at a scale."""
    if scale >= len(tables):
        k = ceil((scale - len(tables) + 1) / 4)
        high = read_number(string, tables, scale - 4 * k)
        return ((high << k) | string.bits_of(k)) - (1 << k - 1)
    row = tables[scale]
    symbol = string.symbol([sum(row[:i]) for i in range(len(row) + 1)])
    if symbol < 41:
        return symbol - 20
    length = string.bits_of(4)
    assert 1 <= length <= 13
    negative = string.bits_of(1)
    size = 20 + (1 << length - 1 | string.bits_of(length - 1))
    return -size if negative else size


def live_tables() -> list[list[int]]:
    """Return the tables of a portrait's numbers."""
    tables: list[list[int]] = np.load(ASSETS / "codec.npz")["live_frequencies"].tolist()
    return tables


def read_tree(string: Range, name: str, count: int | None = None) -> list[list[int]]:
    """Return the points of a tree, steps; with a count only those that come first in its order."""
    tables, arrays = live_tables(), np.load(ASSETS / "portrait.npz")
    mean, order, parents, scales = (
        arrays[f"{name}_{part}"].tolist() for part in ("mean", "order", "parents", "spread")
    )
    deviations: list[list[int]] = []
    order, parents, scales = order[:count], parents[:count], scales[:count]
    points = [[0]] * len(order)
    for point, parent, row in zip(order, parents, scales, strict=True):
        base = deviations[parent] if parent >= 0 else [0] * len(row)
        deviations.append([base[axis] + read_number(string, tables, scale) for axis, scale in enumerate(row)])
        points[point] = [average + by for average, by in zip(mean[point], deviations[-1], strict=True)]
    return points


def read_shape(data: bytes, outline_points: int) -> tuple[list[list[int]], list[list[int]], list[list[int]]]:
    """Return points, neutral pose and outline of a photo, in steps."""
    tables, string = live_tables(), Range(data)
    points = read_tree(string, "face")
    neutral = [
        [points[i][axis] + read_number(string, tables, scales[axis]) for axis in range(3)]
        for i, scales in enumerate(np.load(ASSETS / "portrait.npz")["stir_spread"].tolist())
    ]
    outline: list[list[int]] = []
    for _ in range(outline_points):
        before = outline[-1] if outline else [0, 0]
        outline.append([before[axis] + read_number(string, tables, 28) for axis in range(2)])
    assert string.end() == data
    return points, neutral, outline


def read_view(data: bytes) -> tuple[list[int], list[list[int]], bytes]:
    """Return a view's integers, its control points in steps, and its VP8 frame. data : without the byte of the kind"""
    numbers, shape, frame = msgpack.unpackb(data)
    string = Range(shape)
    points = read_tree(string, "face", len(np.load(ASSETS / "portrait.npz")["stir_spread"]))
    assert string.end() == shape
    return numbers, points, frame


def split_composite(body: bytes) -> list[bytes]:
    """Return the bodies of a composite, or the body alone."""
    parts = []
    while body[0] == 7 or 0x10 <= body[0] < 0x40:
        size, body = (body[1], body[2:]) if body[0] == 7 else (body[0] - 0x0F, body[1:])
        parts.append(body[:size])
        body = body[size:]
    return [*parts, body]


def read_participant(body: bytes) -> tuple[bool, bool, int, str]:
    """Return whether the camera is on, whether the portrait is withdrawn, the number of the head, and the name."""
    assert body[0] == 0x0B and 2 <= len(body) <= 34
    return body[1] % 2 == 0, body[1] // 2 % 2 == 1, body[1] // 4, body[2:].decode("utf-8")


def read_furrows(body: bytes) -> int:
    """Return the level of a furrow body."""
    assert body[0] == 0x0F and len(body) == 2
    return body[1] % 8


def read_candidates(body: bytes) -> tuple[bool, int, int, list[str]]:
    """Return whether an answer is wanted, the revision, the newest one received, and the addresses."""
    assert body[0] == 0x0E
    rest, addresses = body[4:], []
    for _ in range(body[3] // 16):
        addresses.append(".".join(str(byte) for byte in rest[:4]) + f":{rest[4] * 256 + rest[5]}")
        rest = rest[6:]
    for _ in range(body[3] % 16):
        groups = ":".join(rest[at : at + 2].hex() for at in range(0, 16, 2))
        addresses.append(f"{groups}:{rest[16] * 256 + rest[17]}")
        rest = rest[18:]
    assert len(addresses) <= 8 and not rest
    return body[1] >= 128, body[1] % 128, body[2], addresses


def read_voice(body: bytes) -> tuple[int, bool, int, bytes]:
    """Return number, begins, format number and frames of a voice body."""
    head = f"{int.from_bytes(body[:2]):016b}"
    assert head[:2] == "01" and len(body) > 2
    return int(head[2:11], 2), head[11] == "1", int(head[12:], 2), body[2:]


def read_voice_frames(data: bytes, count: int, *, fixed_bits: int | None) -> list[bytes]:
    """Return the frames of a packet. fixed_bits : of each frame, None for a variable-size codec"""
    if fixed_bits is None:
        frames = []
        for _ in range(count - 1):
            frames.append(data[1 : 1 + data[0]])
            data = data[1 + data[0] :]
        return [*frames, data]
    bits = "".join(f"{byte:08b}" for byte in data)
    assert len(bits) - count * fixed_bits in range(8) and "1" not in bits[count * fixed_bits :]
    parts = [bits[i * fixed_bits : (i + 1) * fixed_bits] for i in range(count)]
    padded = [part.ljust(-(-fixed_bits // 8) * 8, "0") for part in parts]
    return [bytes(int(part[i : i + 8], 2) for i in range(0, len(part), 8)) for part in padded]


@dataclass(frozen=True)
class PatchString:
    """The content of a patch's string."""

    descriptor: list[int]
    points: list[list[int]]
    size: tuple[int, int]
    step: int
    planes: list[list[list[list[int]]]]


def read_patch(data: bytes, region: str) -> PatchString:
    """Return the content of the string of a patch, in steps."""
    tables, string, arrays = live_tables(), Range(data), np.load(ASSETS / "portrait.npz")
    descriptor = [read_number(string, tables, scale) for scale in arrays[f"{region}_key_spread"].tolist()]
    points = read_tree(string, region)
    width, height = (1 + string.symbol(uniform(96)) for _ in range(2))
    step = string.symbol(uniform(48))
    planes = []
    for kind, half in ((0, 1), (1, 2), (1, 2)):
        coded, last, scales = (arrays[name][kind].tolist() for name in ("coded", "last", "level_spread"))
        last = [sum(last[:i]) for i in range(len(last) + 1)]
        rows, columns = (ceil(ceil(side / half) / 8) for side in (height, width))
        plane: list[list[list[int]]] = []
        nonempty: dict[tuple[int, int], int] = {}
        for y in range(rows):
            plane.append([])
            for x in range(columns):
                probability = coded[nonempty.get((y, x - 1), 0) + nonempty.get((y - 1, x), 0)]
                nonempty[y, x] = string.symbol([0, TOTAL - probability, TOTAL])
                count = 1 + string.symbol(last) if nonempty[y, x] else 0
                block = [read_number(string, tables, scales[i]) for i in range(count)]
                plane[-1].append(block + [0] * (64 - count))
        planes.append(plane)
    assert string.end() == data
    return PatchString(descriptor, points, (width, height), step, planes)


@dataclass(frozen=True)
class Frame:
    """One coded frame, in steps."""

    values: list[int]
    staggered: bool
    residuals: dict[int, tuple[int, int, int]] = field(default_factory=dict)


def octaves(value: int) -> int:
    """Return L(value) of WIRE.md."""
    return floor(16 * log2(1 + min(value, 1023)))


@dataclass
class PayloadReader:
    """Reads the payloads of one direction of a session in sending order."""

    arrays: dict[str, NDArray[Any]] = field(default_factory=lambda: dict(np.load(ASSETS / "codec.npz")))
    frames: dict[tuple[str, int], Frame] = field(default_factory=dict)

    def read(self, payload: bytes, number: int) -> tuple[str, int, list[int]]:
        """Read a payload; return its profile, its stride and the numbers of its frames, for `motion`."""
        string = Range(payload)
        profile = PROFILES[string.symbol(weighted([30, 2, 2, 2, 2]))]
        count = 1 + string.symbol(weighted([300 if 1 + i in COUNTS[profile] else 1 for i in range(8)]))
        stride = 1 + string.symbol(weighted([300, 3, 1, 1]))
        age = string.symbol(weighted([60, 15, 32, *[19 / i for i in range(3, 64)]]))
        has_second = age > 0 and string.symbol(weighted([1, 40])) == 1
        default = [int(v) for v in self.arrays[f"{TABLES[profile]}_standing"]]
        reference, second = Frame(default, number // (count * stride) % 2 == 1), None
        if age:
            reference = self.frames[profile, number - age]
            second = self.frames[profile, number - age - stride] if has_second else None
        numbers = [number + i * stride for i in range(count)]
        for at in numbers:
            frame = self.read_frame(string, profile, (reference, second, age))
            self.frames[profile, at] = frame
            reference, second, age = frame, (reference if at > number else None), stride
        assert string.end() == payload
        return profile, stride, numbers

    def row(self, age: int, second: Frame | None) -> int:
        """Return the row of context weights of an age."""
        ages = self.arrays["ages"].tolist()
        if age == 0:
            return 0
        nearest = min(range(len(ages)), key=lambda i: (max(age / ages[i], ages[i] / age), ages[i]))
        return 1 + nearest + (len(ages) if second else 0)

    def read_frame(self, string: Range, profile: str, context: tuple[Frame, Frame | None, int]) -> Frame:
        """Read one frame. context : reference, second reference, age"""
        reference, second, age = context
        weights = self.arrays[f"{TABLES[profile]}_weights"][self.row(age, second)].tolist()
        tables = self.arrays[f"{TABLES[profile]}_frequencies"].tolist()
        coupling = int(self.arrays[f"{TABLES[profile]}_growth"])
        old = reference.values
        moves = [abs(a - b) for a, b in zip(old, second.values, strict=True)] if second else [0] * len(old)
        shared = [
            octaves(sum(map(abs, old[6:]))),
            octaves(sum(moves[:6])) if second else 0,
            octaves(sum(moves[6:])) if second else 0,
        ]
        values: list[int] = []
        differences: list[int] = []
        for i, prediction in enumerate(old):
            if i in (4, 5):
                prediction -= prediction * (values[0] - old[0]) * coupling >> 16
            prediction = max(-8191, min(8191, prediction))
            size = values[0] if i else 0
            so_far = [octaves(sum(map(abs, part))) for part in (differences[:6], differences[6:])]
            features = [16, size, *so_far, octaves(moves[i]) if second else 0, *shared]
            scale = sum(w * f for w, f in zip(weights[i], features, strict=True)) // 256
            differences.append(read_number(string, tables, max(0, min(len(tables) - 1 + 32, scale))))
            values.append(prediction + differences[-1])
            assert abs(values[-1]) <= 8191
        return Frame(values, reference.staggered, self._residuals(string, tables, reference))

    def _residuals(self, string: Range, tables: list[list[int]], reference: Frame) -> dict[int, tuple[int, int, int]]:
        result = dict(reference.residuals)
        for _ in range(string.symbol(weighted([3000, 12, 10, 8, 6, 4, 4, 3, 2, 2, 2, 1, 1]))):
            point = string.symbol(uniform(len(self.arrays["correction"])))
            x, y, z = (old + read_number(string, tables, 24) for old in reference.residuals.get(point, (0, 0, 0)))
            result.pop(point, None)
            if (x, y, z) != (0, 0, 0):
                result[point] = (x, y, z)
        return result

    def motion(self, profile: str, at: int, stride: int = 1) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return displacements (n, 3) in FAPU units and pose (6,): rotation, position, log scale."""
        a, frame = self.arrays, self.frames[profile, at]
        v, name = self._dequantise(profile, frame), TABLES[profile]
        shift = np.zeros(len(v))
        for strides in (1, 2):
            earlier = self.frames.get((profile, at - strides * stride))
            if earlier is None:
                break
            d = self._dequantise(profile, earlier) - v
            if strides == 1:
                shift += np.where(np.abs(d) <= 1, a[f"{name}_lean"] * d, 0)
            shift += np.clip(d, -1, 1) @ a[f"{name}_history"][strides - 1].astype(float)
        shift[6:] -= shift[:6] @ a["coupling"]
        v = v + shift
        step = STEPS[profile]
        moved = (step * (v[6:] @ a["synthesis"].astype(float))).reshape(-1, 3)
        for point, steps in frame.residuals.items():
            moved[point] += a["correction"][point] * steps
        scaled = v[:6] * step * a["pose_unit"]
        s = scaled[0] + a["usual_log_scale"]
        x, y, z = scaled[1:4]
        angle = float(np.linalg.norm(scaled[1:4]))
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        rotation = np.eye(3) + np.sinc(angle / np.pi) * cross + 0.5 * np.sinc(angle / 2 / np.pi) ** 2 * cross @ cross
        position = np.exp(s) * (scaled[4:6] - (rotation @ a["middle"])[:2])
        return moved, np.array([x, y, z, *position, s])

    def _dequantise(self, profile: str, frame: Frame) -> NDArray[np.float64]:
        offset = self.arrays["stagger"] if frame.staggered else 0
        return np.array(frame.values, dtype=float) + offset
