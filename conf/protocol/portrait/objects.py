"""The objects of a portrait to bytes and back: the first byte says which of three."""

from collections.abc import Callable

from conf.errors import ProtocolError
from conf.protocol.portrait.patch import Patch, decode_patch, encode_patch
from conf.protocol.portrait.photo import (
    NeutralPoseUpdate,
    Photo,
    decode_neutral,
    decode_photo,
    encode_neutral,
    encode_photo,
)

PortraitObject = Photo | NeutralPoseUpdate | Patch
PHOTO, NEUTRAL, PATCH = 0, 1, 2


def encode_object(thing: PortraitObject, /) -> bytes:
    """Return the bytes of an object."""
    match thing:
        case Photo():
            return bytes((PHOTO,)) + encode_photo(thing)
        case NeutralPoseUpdate():
            return bytes((NEUTRAL,)) + encode_neutral(thing)
        case Patch():
            return bytes((PATCH,)) + encode_patch(thing)


def decode_object(data: bytes, /) -> PortraitObject:
    """Return the object. Raises ProtocolError, whatever the bytes."""
    decoder = _DECODERS.get(data[0]) if data else None
    if decoder is None:
        raise ProtocolError("an object of no known kind")
    return decoder(data[1:])


_DECODERS: dict[int, Callable[[bytes], PortraitObject]] = {
    PHOTO: decode_photo,
    NEUTRAL: decode_neutral,
    PATCH: decode_patch,
}
