"""The objects of a portrait to bytes and back. The first byte is the kind."""

from collections.abc import Callable
from typing import Any

from conf.errors import ProtocolError
from conf.protocol.portrait.background import Background, decode_background, encode_background
from conf.protocol.portrait.patch import Patch, decode_patch, encode_patch
from conf.protocol.portrait.photo import (
    NeutralPoseUpdate,
    Photo,
    decode_neutral,
    decode_photo,
    encode_neutral,
    encode_photo,
)
from conf.protocol.portrait.view import View, decode_view, encode_view

PortraitObject = Photo | NeutralPoseUpdate | Patch | View | Background

_ENCODERS: dict[type, tuple[int, Callable[[Any], bytes]]] = {
    Photo: (0, encode_photo),
    NeutralPoseUpdate: (1, encode_neutral),
    Patch: (2, encode_patch),
    View: (3, encode_view),
    Background: (4, encode_background),
}
_DECODERS: dict[int, Callable[[bytes], PortraitObject]] = {
    0: decode_photo,
    1: decode_neutral,
    2: decode_patch,
    3: decode_view,
    4: decode_background,
}


def encode_object(portrait_object: PortraitObject, /) -> bytes:
    """Return the bytes of an object."""
    kind, encode = _ENCODERS[type(portrait_object)]
    return bytes((kind,)) + encode(portrait_object)


def decode_object(data: bytes, /) -> PortraitObject:
    """Return the object. Raises ProtocolError, whatever the bytes."""
    decode = _DECODERS.get(data[0]) if data else None
    if decode is None:
        raise ProtocolError("an object of unknown kind")
    return decode(data[1:])
