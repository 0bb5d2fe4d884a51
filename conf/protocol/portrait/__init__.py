"""Transfer a portrait and its patches reliably beside a stream of motion. No I/O and no clock.

Strategy. The unit of transfer is an object: a photo, a neutral pose or a patch, up to 12 kB, in a numbered slot. The
sender cuts it into chunks and sends them within a budget, with lower priority than motion. The receiver reassembles
objects and acknowledges chunks; unacknowledged chunks are sent again. A newer object in a slot replaces the older one,
so both sides hold the same few slots.

Reading order: chunks, object_sender, object_receiver, photo, patch.
"""

from conf.protocol.portrait.object_receiver import ObjectReceiver
from conf.protocol.portrait.object_sender import ObjectSender
from conf.protocol.portrait.objects import decode_object, encode_object
from conf.protocol.portrait.patch import Patch, decode_patch, encode_patch
from conf.protocol.portrait.photo import NeutralPoseUpdate, Photo

__all__ = [
    "NeutralPoseUpdate",
    "ObjectReceiver",
    "ObjectSender",
    "Patch",
    "Photo",
    "decode_object",
    "decode_patch",
    "encode_object",
    "encode_patch",
]
