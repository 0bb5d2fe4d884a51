"""`conf measure`: what one frame costs at every stage of its way, beside raw pixels."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from conf.errors import CameraError
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.output.media_writer import save_picture
from conf.protocol.codec import LIVE, PROFILES
from conf.protocol.loopback import LoopbackCall
from conf.protocol.messages import StreamParameters
from conf.protocol.sender_connection import RateOptions
from conf.protocol.statistics import raw_frame_bytes
from conf.render.ui.charts import Bar, bar_chart
from conf.sender.capture.video import open_clip
from conf.sender.frame_pacer import FramePacer
from conf.sender.motion.extractor import MotionExtractor
from conf.sender.tracking.canonical_face import read_canonical_face
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.offline import Progress, track_clip

SEAL_BYTES = 14  # framing and seal of a datagram; WIRE.md counts them
JPEG_QUALITY = 30  # about the lowest at which a face is pleasant to look at


@dataclass(frozen=True)
class StageCost:
    """One stage: mean bytes a frame, what that makes at `fps`, and how often it fits into raw pixels."""

    name: str
    bytes_per_frame: float
    fps: float
    kbps: float
    ratio: float


def measure(clip: Path, profile: str = LIVE.name, on_progress: Progress | None = None) -> list[StageCost]:
    """Make a call with a clip, without a network, and count. Raises CameraError, ModelError."""
    with open_clip(clip) as source:
        size, fps = source.size, min(source.fps, float(PROFILES[profile].fps))
    extractor = MotionExtractor(read_canonical_face(fetch_models()), size)
    parameters = StreamParameters(*size, fps, CONTROL_POINT_COUNT, extractor.fapu_distances())
    call = LoopbackCall(parameters, 0.0, link=RateOptions(profile))
    pace, frames, jpeg = FramePacer(fps), 0, 0
    for frame, tracking in track_clip(clip, on_progress):
        now = frame.timestamp
        if tracking is None or pace.delay_for(now, now) is None:
            continue
        call.send_frame(extractor.update(tracking, now), now)
        frames += 1
        jpeg += len(cv2.imencode(".jpg", frame.pixels, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1])
    if not frames:
        raise CameraError(f"{clip} shows no face: choose a clip in which one face is well seen")
    coded = call.sealed_bytes - SEAL_BYTES * call.datagrams
    raw = raw_frame_bytes(*size)
    costs = {
        f"raw pixels {size[0]}x{size[1]}": float(raw),
        f"JPEG, quality {JPEG_QUALITY}": jpeg / frames,
        "478 landmarks, float32": 478 * 3 * np.float32().nbytes,
        f"{CONTROL_POINT_COUNT} points and pose, float32": (CONTROL_POINT_COUNT * 3 + 6) * np.float32().nbytes,
        "coded": coded / frames,
        "sealed datagrams": call.sealed_bytes / frames,
        "with UDP/IP headers": call.wire_bytes / frames,
    }
    return [StageCost(name, cost, fps, cost * fps * 8 / 1000, raw / cost) for name, cost in costs.items()]


def plot(stages: list[StageCost], path: Path) -> None:
    """Draw the stages as bars on a logarithmic scale. Raises RecordingError, GraphicsError."""
    bars = [
        Bar(stage.name, stage.bytes_per_frame, f"{stage.bytes_per_frame:,.0f} B, {stage.kbps:,.1f} kbit/s")
        for stage in stages
    ]
    save_picture(path, bar_chart("bytes a frame", bars))
