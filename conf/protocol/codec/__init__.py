"""The motion codec: fifty displacements and a head pose in a few bytes, and back. Pure.

Strategy. A frame is turned into about twenty numbers of equal worth (transform.py), each number into its difference
from a frame that the receiver is known to have (encoder.py, prediction.py), each difference into a symbol of a trained
table chosen by its context (syntax.py, model.py, symbols.py), the symbols into bytes (range_coder.py). The order of
symbols is written once for both directions. tools/train/codec.py makes the tables, tools/bench/codec.py measures.

Reading order: profiles, transform, range_coder, symbols, syntax, bundle, prediction, encoder, decoder.
"""

from conf.protocol.codec.decoder import DecodedFrame, Decoder
from conf.protocol.codec.encoder import Encoder
from conf.protocol.codec.profiles import LIVE, NARROWBAND, PROFILES, RICH, Profile
from conf.protocol.codec.reference_frames import MissingReferenceError

__all__ = [
    "LIVE",
    "NARROWBAND",
    "PROFILES",
    "RICH",
    "DecodedFrame",
    "Decoder",
    "Encoder",
    "MissingReferenceError",
    "Profile",
]
