"""The voice of a call: encoded frames in, message bodies out, and back to frames in order of time. No codec, no I/O.

Reading order: formats, packing, outbound, inbound.
"""
