"""The receiving half of the codec: a payload and the number of its first frame in, motion out."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.errors import ProtocolError
from conf.protocol.codec.model import CodecModel, load_models
from conf.protocol.codec.payload_header import PayloadHeader, code_header
from conf.protocol.codec.prediction import first_context, next_context
from conf.protocol.codec.profiles import LIVE
from conf.protocol.codec.quantised_frame import QuantisedFrame
from conf.protocol.codec.reference_frames import ReferenceFrames
from conf.protocol.codec.symbol_coder import SymbolReader
from conf.protocol.codec.syntax import FrameCoder, code_point_residuals

MAX_PAYLOAD = 1100
_ANY_HEADER = PayloadHeader(LIVE.name, count=1, stride=1, age=0, second_reference=False)


@dataclass(frozen=True)
class DecodedFrame:
    """One frame of motion.

    number : ticks of the frame clock
    displacements : (n, 3) float32, FAPU units
    pose : (6,) float64, as in conf.protocol.messages
    """

    frame_number: int
    displacements: NDArray[np.float32]
    pose: NDArray[np.float64]


class Decoder:
    """Decode payloads in whatever order they arrive: a loss costs the frames that were lost and no others."""

    def __init__(self, models: Mapping[str, CodecModel] | None = None) -> None:
        self._models = load_models() if models is None else models
        self._references = {name: ReferenceFrames() for name in self._models}  # each profile counts its own ticks

    def decode(self, payload: bytes, number: int) -> list[DecodedFrame]:
        """Return the frames of a payload, oldest first.

        number : of the payload's first frame
        Raises MissingReferenceError when the frame it is predicted from never came, ProtocolError when the bytes are
        not what an Encoder writes. Neither changes what is remembered.
        """
        if len(payload) > MAX_PAYLOAD:
            raise ProtocolError("payload too long")
        header, frames = self._read(payload, number)
        transform = self._models[header.profile].transform
        history = self._references[header.profile]
        decoded = []
        for position, frame in enumerate(frames):
            at = number + position * header.stride
            history.add(at, frame)
            before = history.get(at - header.stride)
            decoded.append(DecodedFrame(at, *transform.inverse(frame, before)))
        return decoded

    def _read(self, payload: bytes, number: int) -> tuple[PayloadHeader, list[QuantisedFrame]]:
        reader = SymbolReader(payload)
        header = code_header(reader, _ANY_HEADER)
        model = self._models[header.profile]
        context = first_context(model, header, number, self._references[header.profile].require)
        frames: list[QuantisedFrame] = []
        for _ in range(header.count):
            frame = FrameCoder(reader, model, context)
            frame.code(model.default_reference.values)
            corrections = code_point_residuals(reader, model, context.reference.residuals, {})
            frames.append(QuantisedFrame(tuple(frame.values), context.reference.staggered, corrections))
            context = next_context(model, header, frames)
        reader.finish()
        return header, frames
