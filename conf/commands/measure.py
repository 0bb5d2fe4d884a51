"""`conf measure`: bytes a frame at every stage of the encoding, compared with raw pixels."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from conf.atomic_write import check_writable
from conf.commands import Terminal
from conf.commands.extract import progress_text
from conf.commands.support.arguments import add_json
from conf.errors import AudioError, CameraError

if TYPE_CHECKING:
    from conf.protocol.messages import MotionFrame, StreamParameters
    from conf.sender.capture.clip import Clip

HELP = "bytes a frame at every stage of the encoding, compared with raw pixels"
SEAL_BYTES = 14  # framing and authentication tag of a datagram, see WIRE.md
JPEG_QUALITY = 30  # about the lowest at which a face looks acceptable
RTP_BYTES = 12  # header of a packet, RFC 3550
OPUS_BIT_RATE, OPUS_FRAME_MS = 6000, 20  # of a call over RTP: the usual packets, at the rate below which Opus fails
VOICE_KBPS = 16.0  # of our call with face and voice
BOTH = "face and voice, one datagram"
STEP_S = 0.005  # of the simulated call with voice


@dataclass(frozen=True)
class StageCost:
    """The mean cost of one stage.

    bytes_per_frame : of voice, what is sent in the time of a frame
    ratio : raw pixels to this stage; of voice alone raw sound, of both together both
    """

    name: str
    bytes_per_frame: float
    fps: float
    kbps: float
    ratio: float


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("clip", type=Path, help="any clip with a face")
    parser.add_argument(
        "--profile", choices=["live", "narrow", "rich"], default="live", help="as for conf send (default live)"
    )
    parser.add_argument("--plot", type=Path, metavar="OUT.png", help="draw the table as a bar chart")
    add_json(parser)


def run(options: argparse.Namespace, terminal: Terminal) -> None:
    from rich.table import Table

    if options.plot:
        check_writable(options.plot)
    with terminal.status_line() as show:
        stages = measure(
            options.clip,
            options.profile,
            on_progress=lambda *counts: show(progress_text(*counts)),
            on_note=terminal.write,
        )
    if options.plot:
        plot(stages, options.plot)
    table = Table("stage", "B a frame", "kbit/s", "raw : this")
    for stage in stages:
        table.add_row(stage.name, f"{stage.bytes_per_frame:,.1f}", f"{stage.kbps:,.1f}", f"{stage.ratio:,.0f}")
    terminal.print_list("stages", stages, table)
    if options.plot:
        terminal.write(f"saved {options.plot.absolute()}")


def measure(
    clip: Path,
    profile: str = "live",
    *,
    on_progress: Callable[[int, int], None] | None = None,
    on_note: Callable[[str], None] = lambda text: None,
) -> list[StageCost]:
    """Return the cost of each stage of a call with a clip, without a network; on_note gets what was odd about the clip.

    Raises CameraError, ModelError.
    """
    import cv2
    import numpy as np

    from conf.face.control_points import CONTROL_POINT_COUNT
    from conf.protocol.codec.profiles import PROFILES
    from conf.protocol.loopback import LoopbackCall
    from conf.protocol.messages import MotionFrame, StreamParameters
    from conf.protocol.rate_control.send_budget import RateOptions
    from conf.protocol.statistics import raw_frame_bytes
    from conf.sender.frame_pacer import FramePacer
    from conf.sender.motion.extractor import MotionExtractor
    from conf.sender.motion.furrows import FurrowEstimator
    from conf.sender.tracking.canonical_face import load_canonical_face
    from conf.sender.tracking.model_files import fetch_models
    from conf.sender.tracking.offline import track_frames
    from conf.sender.tracking.orientation import open_upright_clip

    with open_upright_clip(clip, fetch_models(), on_note=on_note) as source:
        size, fps = source.size, min(source.fps, float(PROFILES[profile].fps))
        extractor = MotionExtractor(load_canonical_face(), size)
        parameters = StreamParameters(*size, fps, CONTROL_POINT_COUNT, astuple(extractor.fapu))
        call = LoopbackCall(parameters, 0.0, os.urandom, rate=RateOptions(profile))
        pacer, furrows, motion, jpeg_bytes = FramePacer(fps), FurrowEstimator(), list[MotionFrame](), 0
        for frame, tracking in track_frames(source, on_progress):
            now = frame.timestamp
            if tracking is None or pacer.delay_for(now, now) is None:
                continue
            motion.append(furrows.add_furrows(extractor.update(tracking, now), tracking, frame.pixels))
            call.send_frame(motion[-1], now)
            jpeg_bytes += len(cv2.imencode(".jpg", frame.pixels, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1])
        if not motion:
            raise CameraError(f"{clip} shows no face: choose a clip in which one face is clearly visible")
        frames = len(motion)
        seconds = motion[-1].timestamp - motion[0].timestamp
        if frames > 1:
            fps = (frames - 1) / seconds  # of clips whose frames are uneven in time
        voice = _measure_voice(clip, source, motion, parameters, on_note)
    coded = call.sealed_bytes - SEAL_BYTES * call.datagrams
    raw = raw_frame_bytes(*size)
    costs = {
        f"raw pixels {size[0]}x{size[1]}": float(raw),
        f"JPEG, quality {JPEG_QUALITY}": jpeg_bytes / frames,
        "478 landmarks, float32": 478 * 3 * np.float32().nbytes,
        f"{CONTROL_POINT_COUNT} points and pose, float32": (CONTROL_POINT_COUNT * 3 + 6) * np.float32().nbytes,
        "coded": coded / frames,
        "sealed datagrams": call.sealed_bytes / frames,
        "with UDP/IP headers": call.wire_bytes / frames,
    }
    stages = [StageCost(name, cost, fps, cost * fps * 8 / 1000, raw / cost) for name, cost in costs.items()]
    for name, rate in voice.items():
        raw_rate = next(iter(voice.values())) + (raw * fps if name == BOTH else 0)
        stages.append(StageCost(name, rate / fps, fps, rate * 8 / 1000, raw_rate / rate))
    return stages


def _measure_voice(
    path: Path, clip: Clip, motion: list[MotionFrame], parameters: StreamParameters, on_note: Callable[[str], None]
) -> dict[str, float]:
    """Return the bytes a second of each stage of a clip's sound, raw sound first; nothing if it has none.

    motion : of the frames sent; the sound is measured from the first to the last
    """
    import numpy as np

    from conf.audio.codecs.registry import create_encoder
    from conf.audio.processing import VoiceProcessor
    from conf.audio.samples import SAMPLE_RATE
    from conf.protocol.loopback import LoopbackCall
    from conf.protocol.rate_control.rate_levels import VoiceMode
    from conf.protocol.rate_control.send_budget import RateOptions
    from conf.protocol.statistics import HEADER_BYTES
    from conf.sender.capture.sound import FileSoundSource
    from conf.sender.voice.voice_sender import VoiceSender

    first, last = motion[0].timestamp, motion[-1].timestamp
    try:
        whole, sound = FileSoundSource(path, clip=clip), FileSoundSource(path, clip=clip)
    except CameraError:
        return {}
    try:
        encoder = create_encoder("opus", OPUS_BIT_RATE, OPUS_FRAME_MS)
        processor = VoiceProcessor()
    except AudioError as error:
        on_note(f"voice is not measured: {error}")
        return {}
    samples = np.concatenate([np.zeros(0, np.int16), *(block.samples for block in whole.read(last))])
    size = SAMPLE_RATE * OPUS_FRAME_MS // 1000
    packets = [encoder.encode(frame) for frame in samples[: len(samples) // size * size].reshape(-1, size)]
    if not packets:
        return {}
    rate = RateOptions(kbps=VOICE_KBPS, voice=VoiceMode.AUTOMATIC)
    call, sender = LoopbackCall(parameters, first, os.urandom, rate=rate), VoiceSender(sound, processor)
    pending = motion[::-1]
    for step in range(round((last - first) / STEP_S) + 1):
        now = first + step * STEP_S
        while pending and pending[-1].timestamp <= now:
            call.sender.send_frame(pending.pop(), now)
        sender.poll(now, call.sender, now)
        call.exchange(now)
    for opened in (whole, sound):
        opened.close()
    rtp = sum(len(packet) + RTP_BYTES + HEADER_BYTES for packet in packets) / (len(packets) * OPUS_FRAME_MS / 1000)
    return {
        f"sound, PCM {SAMPLE_RATE // 1000} kHz": float(SAMPLE_RATE * samples.itemsize),
        f"voice, Opus {OPUS_BIT_RATE} in RTP, {OPUS_FRAME_MS} ms": rtp,
        BOTH: call.wire_bytes / (last - first) * (len(motion) - 1) / len(motion),  # each frame lasts until the next
    }


def plot(stages: list[StageCost], path: Path) -> None:
    """Write a bar chart of the stages, with a logarithmic scale. Raises RecordingError, GraphicsError."""
    from conf.output.image_writer import save_image
    from conf.render.ui.charts import bar_chart

    bars = [
        (stage.name, stage.bytes_per_frame, f"{stage.bytes_per_frame:,.0f} B, {stage.kbps:,.1f} kbit/s")
        for stage in stages
    ]
    save_image(path, bar_chart("bytes a frame", bars))
