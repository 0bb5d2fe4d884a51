"""`conf send`: track a face and send its motion."""

import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.protocol.caller import Caller, LinkOptions
from conf.protocol.messages import StreamParameters
from conf.protocol.session.client import SenderSession
from conf.sender.canonical_face import read_canonical_face
from conf.sender.models import fetch_models
from conf.sender.motion import MotionExtractor
from conf.sender.pipeline import SenderStatus, SendingLoop
from conf.sender.sources import Camera, Clip, open_camera, open_clip
from conf.sender.tracker import FaceTracker
from conf.sender.udp import SenderSocket

FPS = 15.0


@dataclass(frozen=True)
class Sending:
    """What is sent and for how long.

    file : a clip as a fake camera, else the camera by its number or device
    """

    camera: str = "0"
    file: Path | None = None
    loop: bool = False
    seconds: float | None = None
    link: LinkOptions = field(default_factory=LinkOptions)


def send(
    receiver: tuple[str, int], code: str, sending: Sending, on_status: Callable[[SenderStatus], None] | None = None
) -> SenderStatus:
    """Send until the clip ends, the time is over or the user stops it.

    code : what the receiver shows, as normalise_code returns it
    Raises CameraError, ModelError, NetworkError.
    """
    models = fetch_models()
    with SenderSocket(*receiver) as link, _open_source(sending) as source:
        extractor = MotionExtractor(read_canonical_face(models), source.size)
        parameters = StreamParameters(*source.size, min(FPS, source.fps), CONTROL_POINT_COUNT, extractor.fapu_lengths())
        now = time.monotonic()
        session = SenderSession(code, link.remote, os.urandom, now)
        caller = Caller(session, parameters, now, link=sending.link)
        loop = SendingLoop(source, FaceTracker(models), extractor, caller, link)
        return loop.run(seconds=sending.seconds, on_status=on_status)


def _open_source(sending: Sending) -> Camera | Clip:
    if sending.file is not None:
        return open_clip(sending.file, loop=sending.loop)
    return open_camera(sending.camera)
