"""Transfer a portrait and its patches reliably beside a stream of motion. No I/O and no clock.

Strategy. The unit of transfer is an object: a photo, a neutral pose, a patch or a view, up to 12 kB, in a numbered
slot. The sender cuts it into chunks and sends them within a budget, with lower priority than motion. The receiver
reassembles objects and acknowledges chunks; unacknowledged chunks are sent again. A newer object in a slot replaces the
older one, so both sides hold the same few slots.

Reading order: chunks, object_sender, object_receiver, photo, patch, view.
"""
