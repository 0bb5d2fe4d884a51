"""A call of two: one loop that captures, sends, receives, draws and plays, from the parts of sender and receiver.

Reading order: loop, capture_thread, local_state, self_view.
"""
