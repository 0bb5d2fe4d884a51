"""WIRE.md agrees with the code: its examples decode, and its tables and limits are the code's."""

import hashlib
import re
from importlib.resources import files
from pathlib import Path

import msgpack
import numpy as np
import pytest

from conf.protocol import stream_clocks, wire
from conf.protocol.codec.payload_header import code_header
from conf.protocol.codec.profiles import PROFILES
from conf.protocol.codec.symbol_coder import SymbolReader
from conf.protocol.portrait.objects import decode_object, encode_object
from conf.protocol.portrait.patch import encode_patch
from conf.protocol.portrait.photo import decode_photo, encode_photo
from conf.protocol.portrait.probability_model import REGIONS
from conf.protocol.portrait.view import View
from conf.protocol.rate_control.rate_levels import VOICE_LEVELS
from conf.protocol.session.drop_reasons import DropReason
from conf.protocol.session.packet import parse_datagram
from conf.protocol.voice.formats import VoiceFormat
from conf.protocol.wire import decode_body
from tests.protocol.independent_decoder import (
    PayloadReader,
    read_candidates,
    read_furrows,
    read_patch,
    read_shape,
    read_view,
)
from tests.support.portrait_objects import example_patch, example_photo
from tools.golden.wire import BODIES, FOLDER, HEADERS

TEXT = (Path(wire.__file__).parent / "WIRE.md").read_text()
# A name, then groups of hex digits, possibly continued on further indented lines.
BLOCK = re.compile(r"^    ([a-z_]+) +((?:[0-9a-f]{2})+(?:\s+(?:[0-9a-f]{2})+)*)$", re.MULTILINE)
EXAMPLES = {name: bytes.fromhex("".join(words.split())) for name, words in BLOCK.findall(TEXT)}


def numbers(text: str) -> list[int]:
    """Return the integers of a text."""
    return [int(n) for n in re.findall(r"-?\d+", text)]


def test_every_golden_file_has_an_example() -> None:
    headers = {f"header_{name}" for name in HEADERS}
    datagrams = {path.stem.removeprefix("session_") for path in FOLDER.glob("session_[!i]*.bin")} - {"data_long"}
    assert set(EXAMPLES) == set(BODIES) | headers | datagrams | {"payload_live"}


@pytest.mark.parametrize("name", BODIES)
def test_example_bodies_decode_to_the_golden_messages(name: str) -> None:
    assert decode_body(EXAMPLES[name]) == BODIES[name]
    assert (FOLDER / f"body_{name}.bin").read_bytes() == EXAMPLES[name]


def test_the_addresses_of_a_body_are_as_wire_md_describes() -> None:
    assert read_candidates(EXAMPLES["path_candidates"]) == (
        True,
        2,
        1,
        ["198.51.100.7:40000", "10.1.0.2:40000", "2001:0db8:0000:0000:0000:0000:0000:0007:40000"],
    )


def test_the_level_of_furrows_is_as_wire_md_describes() -> None:
    assert read_furrows(EXAMPLES["furrows"]) == 5


@pytest.mark.parametrize("name", HEADERS)
def test_example_headers_decode(name: str) -> None:
    reader = SymbolReader(EXAMPLES[f"header_{name}"])
    assert code_header(reader) == HEADERS[name]
    reader.finish()


def test_the_example_payload_decodes_to_the_stated_values() -> None:
    payload = EXAMPLES["payload_live"]
    assert (FOLDER / "codec_live_0.bin").read_bytes() == payload
    _, values, residual = re.split(r"Its values are|; point", TEXT.split("payload_live")[1].split("### Errors")[0])
    reader = PayloadReader()
    assert reader.read(payload, 0) == ("live", 1, [0])
    frame = reader.frames["live", 0]
    assert numbers(values) == frame.values and not frame.staggered
    point, x, y, z = numbers(residual.split(".")[0])
    assert frame.residuals == {point: (x, y, z)}
    pose = [float(n) for n in re.findall(r"-?\d\.\d+", residual)]
    assert pose == pytest.approx(reader.motion("live", 0)[1], abs=1e-6)


@pytest.mark.slow
def test_the_independent_decoder_reads_the_shape_of_a_photo() -> None:
    photo = decode_photo(encode_photo(example_photo()))
    _, shape, _ = msgpack.unpackb(encode_photo(photo))
    points, neutral, outline = read_shape(shape, len(photo.outline))
    np.testing.assert_allclose(np.array(points) * 0.02, photo.points, atol=1e-9)
    np.testing.assert_allclose(np.array(neutral) * 0.02, photo.neutral, atol=1e-9)
    np.testing.assert_allclose(np.array(outline) / 255, photo.outline, atol=1e-9)


def test_the_independent_decoder_reads_the_golden_view() -> None:
    golden = (FOLDER / "portrait_view.bin").read_bytes()
    view = decode_object(golden)
    assert isinstance(view, View) and encode_object(view) == golden
    read, points, frame = read_view(golden[1:])
    assert golden[0] == 3 and read[:2] == [view.photo_number, view.slot] and frame == view.frame
    np.testing.assert_allclose(np.array(read[2:6]) / 255, view.box)
    np.testing.assert_allclose(np.array(read[6:]) * 0.0005, view.pose)
    np.testing.assert_allclose(np.array(points) * 0.02, view.points)


@pytest.mark.parametrize("region", range(len(REGIONS)))
def test_the_independent_decoder_reads_a_patch(region: int) -> None:
    sent = example_patch(region=region)
    read = read_patch(encode_patch(sent)[3:], REGIONS[region])
    assert (read.descriptor, read.size, read.step) == (sent.descriptor.tolist(), sent.size, sent.step)
    np.testing.assert_array_equal(read.points, np.rint(sent.points * 127.5))
    for expected, plane in zip(sent.coefficients, read.planes, strict=True):
        np.testing.assert_array_equal(plane, expected)


@pytest.mark.parametrize("path", sorted(FOLDER.glob("session_[!i]*.bin")), ids=lambda path: path.stem)
def test_example_datagrams_are_the_golden_files(path: Path) -> None:
    name = path.stem.removeprefix("session_")
    if name != "data_long":
        assert path.read_bytes() == EXAMPLES[name]
        parse_datagram(EXAMPLES[name])


def _frames(voice_format: VoiceFormat) -> str:
    one = f"{voice_format.codec} {voice_format.bit_rate}, {voice_format.frame_ms} ms"
    packet = one if voice_format.frames == 1 else f"{one} x {voice_format.frames}"
    return f"{packet}, {voice_format.repeated} repeated" if voice_format.repeated else packet


def test_tables_and_limits_equal_those_of_the_code() -> None:
    for profile in PROFILES.values():
        delay = "0" if not profile.delay else f"{profile.delay * 1000:.0f} ms"
        fps = "50/3" if profile.fps == 50 / 3 else f"{profile.fps:g}"
        counts = ", ".join(map(str, profile.usual_counts))
        row = (profile.name, fps, profile.frames_per_datagram, delay, profile.step, counts)
        assert f"| {' | '.join(map(str, row))} |" in TEXT
    for level in VOICE_LEVELS:
        assert level.voice is not None
        assert f"| {level.kbps:g} | {_frames(level.voice)} | {level.voice.packet_ms} ms | {level.profile} x " in TEXT
        for lossy in level.lossy:
            assert f"| {level.kbps:g} | {lossy.loss * 100:.0f} % | {_frames(lossy.voice)} | " in TEXT
    assert f"1 to {wire.MAX_BODY:,} B" in TEXT
    assert f"at most {stream_clocks.MAX_DELAY_S * 1000:.0f} ms" in TEXT
    for reason in DropReason:
        assert f"`{reason}`" in TEXT


@pytest.mark.parametrize("name", ["codec.npz", "portrait.npz"])
def test_digests_of_the_table_files_are_current(name: str) -> None:
    digest = hashlib.sha256(files("conf.assets").joinpath(name).read_bytes()).hexdigest()
    assert f"`{digest[:16]}...`" in TEXT, "new tables: write new golden files, update WIRE.md"


def test_lines_are_short() -> None:
    assert max(len(line) for line in TEXT.splitlines()) <= 140
