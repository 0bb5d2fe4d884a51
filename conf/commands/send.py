"""`conf send`: track a face and send its motion."""

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from conf.commands.preview import Preview
from conf.face.control_points import CONTROL_POINT_COUNT
from conf.protocol.messages import StreamParameters
from conf.protocol.portrait import ObjectSender
from conf.protocol.sender_connection import RateOptions, SenderConnection
from conf.protocol.session.client import SenderSession
from conf.sender.capture.video import Frame, open_camera, open_clip
from conf.sender.motion.extractor import MotionExtractor
from conf.sender.motion_source import MotionSource, TrackedMotionSource, open_motion_file
from conf.sender.pipeline import SenderLoop, SenderStatus
from conf.sender.portrait.scheduler import PortraitScheduler
from conf.sender.tracking.canonical_face import read_canonical_face
from conf.sender.tracking.model_files import fetch_models
from conf.sender.tracking.tracker import FaceTracker, TrackedFace
from conf.transport.udp import UdpSocket

FPS = 15.0

OnFrame = Callable[[Frame, TrackedFace | None], None]


@dataclass(frozen=True)
class SendOptions:
    """What is sent and for how long.

    calibrate : take the first face seen for the neutral pose
    preview : show what the camera sees in a window
    portrait_kbps : what the person's picture may cost; None lets none leave the machine
    file : a clip as a fake camera; dpc : a recorded motion; else the camera by its number or device
    """

    camera: str = "0"
    file: Path | None = None
    dpc: Path | None = None
    loop: bool = False
    seconds: float | None = None
    calibrate: bool = False
    preview: bool = False
    portrait_kbps: float | None = None
    link: RateOptions = field(default_factory=RateOptions)


def send(
    receiver: tuple[str, int], code: str, sending: SendOptions, on_status: Callable[[SenderStatus], None] | None = None
) -> SenderStatus:
    """Send until the clip ends, the time is over or the user stops it.

    code : what the receiver shows, as normalise_code returns it
    Raises CameraError, ModelError, NetworkError, FileFormatError.
    """
    outbox = ObjectSender(kbps=sending.portrait_kbps) if sending.portrait_kbps else None
    with UdpSocket.open_to(*receiver) as link, _open(sending, outbox) as performance:
        size, fps = performance.size, min(FPS, performance.fps)
        parameters = StreamParameters(*size, fps, CONTROL_POINT_COUNT, performance.fapu_lengths)
        now = time.monotonic()
        assert link.remote is not None
        session = SenderSession(code, link.remote, os.urandom, now)
        caller = SenderConnection(session, parameters, now, link=sending.link, portrait=outbox)
        return SenderLoop(performance, caller, link).run(seconds=sending.seconds, on_status=on_status)


@contextmanager
def _open(sending: SendOptions, outbox: ObjectSender | None) -> Iterator[MotionSource]:
    if sending.dpc is not None:
        yield open_motion_file(sending.dpc, loop=sending.loop)
        return
    models = fetch_models()
    with open_clip(sending.file, loop=sending.loop) if sending.file else open_camera(sending.camera) as source:
        canonical = read_canonical_face(models)
        extractor = MotionExtractor(canonical, source.size)
        studio = PortraitScheduler(canonical, outbox) if outbox else None
        if sending.calibrate:
            extractor.set_neutral_now()
        with _preview(sending, source.size, extractor) as on_frame:
            yield TrackedMotionSource(
                source, FaceTracker(models), extractor, portrait_scheduler=studio, on_frame=on_frame
            )


@contextmanager
def _preview(sending: SendOptions, size: tuple[int, int], extractor: MotionExtractor) -> Iterator[OnFrame | None]:
    if not sending.preview:
        yield None
        return
    preview = Preview(size)

    def show(frame: Frame, tracking: TrackedFace | None) -> None:
        preview.show(frame, tracking)
        if preview.neutral_wanted:
            preview.neutral_wanted = False
            extractor.set_neutral_now()

    try:
        yield show
    finally:
        preview.close()
