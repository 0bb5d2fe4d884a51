"""Carry a portrait and its patches reliably under a stream of motion. Pure: bytes and times.

Strategy. What is to arrive is an object: up to 12 kB of bytes in a slot, numbered. The outbox cuts it into pieces that
ride under the motion's priority within a budget; the inbox collects them and says what it has; what was not heard of is
sent again. A newer object in a slot replaces the older one, so both sides hold the same few slots.

Reading order: pieces, outbox, inbox, photograph, patch.
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
