"""The motion codec: 50 displacements and a head pose to a few bytes, and back. No I/O.

Strategy. A frame is transformed to 32 values of equal importance (transform.py). Each value is coded as its
difference from a frame that the receiver is known to have (encoder.py, reference_frames.py), each difference as a
symbol of a trained table that its context selects (syntax.py, model.py, symbol_coder.py), and the symbols as bytes
(range_coder.py). The order of symbols is written once for both directions. tools/train/codec.py trains the tables,
tools/bench/codec.py measures.

Reading order: profiles, reconstruction, transform, range_coder, symbol_coder, payload_header, syntax, encoder, decoder.
"""
