"""The decoder: a payload and the number of its first frame to motion."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conf.errors import ProtocolError
from conf.protocol.codec.model import CodecModel, load_models
from conf.protocol.codec.payload_header import PayloadHeader, code_header
from conf.protocol.codec.reference_frames import QuantisedFrame, ReferenceFrames
from conf.protocol.codec.symbol_coder import SymbolReader
from conf.protocol.codec.syntax import FrameCoder, code_point_residuals, first_context, next_context

MAX_PAYLOAD = 1100


@dataclass(frozen=True)
class DecodedFrame:
    """One frame of motion.

    frame_number : ticks of the frame clock
    displacements : (n, 3) float32, FAPU units
    pose : (6,) float64, as in MotionFrame
    """

    frame_number: int
    displacements: NDArray[np.float32]
    pose: NDArray[np.float64]


class Decoder:
    """Decode payloads in any order: a lost payload costs its own frames and no others."""

    def __init__(self, models: Mapping[str, CodecModel] | None = None) -> None:
        self._models = load_models() if models is None else models
        self._references = {name: ReferenceFrames() for name in self._models}  # each profile counts its own ticks

    def decode(self, payload: bytes, frame_number: int) -> list[DecodedFrame]:
        """Return the frames of a payload, oldest first.

        frame_number : of the payload's first frame
        Raises MissingReferenceError if its reference was never received, ProtocolError if no Encoder writes such bytes.
        After either, the state is unchanged.
        """
        if len(payload) > MAX_PAYLOAD:
            raise ProtocolError("payload too long")
        header, frames = self._read(payload, frame_number)
        transform = self._models[header.profile].transform
        references = self._references[header.profile]
        decoded = []
        for position, frame in enumerate(frames):
            number = frame_number + position * header.stride
            references.add(number, frame)
            earlier = references.before(number, header.stride)
            decoded.append(DecodedFrame(number, *transform.inverse(frame, earlier)))
        return decoded

    def _read(self, payload: bytes, frame_number: int) -> tuple[PayloadHeader, list[QuantisedFrame]]:
        reader = SymbolReader(payload)
        header = code_header(reader)
        model = self._models[header.profile]
        context = first_context(model, header, frame_number, self._references[header.profile].require)
        frames: list[QuantisedFrame] = []
        for _ in range(header.count):
            frame = FrameCoder(reader, model, context)
            frame.code(model.default_reference.values)
            residuals = code_point_residuals(reader, model, context.reference.residuals, {})
            frames.append(QuantisedFrame(tuple(frame.values), context.reference.staggered, residuals))
            context = next_context(model, header, frames)
        reader.finish()
        return header, frames
