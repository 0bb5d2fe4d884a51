"""What each frame of a bundle is predicted from: the first from what was acknowledged, the others from the one before.

Within a payload prediction is free of risk: its frames arrive together or not at all.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from conf.protocol.codec.model import CodecModel
from conf.protocol.codec.payload_header import PayloadHeader
from conf.protocol.codec.quantised_frame import QuantisedFrame
from conf.protocol.codec.syntax import Context

Recall = Callable[[int], QuantisedFrame]


def first_context(model: CodecModel, header: PayloadHeader, number: int, recall: Recall) -> Context:
    """Return what frame `number`, the first of its bundle, is predicted from. `recall` gives remembered frames."""
    if not header.age:
        return Context(model.rows[0], replace(model.default_reference, staggered=header.is_staggered(number)))
    at = number - header.age
    if header.second_reference:
        return Context(model.second_reference_rows[header.age], recall(at), recall(at - header.stride))
    return Context(model.rows[header.age], recall(at))


def next_context(model: CodecModel, header: PayloadHeader, before: Sequence[QuantisedFrame]) -> Context:
    """Return what the frame after those `before` it in the bundle is predicted from."""
    if len(before) > 1:
        return Context(model.second_reference_rows[header.stride], before[-1], before[-2])
    return Context(model.rows[header.stride], before[-1])
