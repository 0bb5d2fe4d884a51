"""A call of two: one loop that captures, sends, receives, draws and plays, from the parts of sender and receiver.

Reading order: loop, capture_thread, events, early_exchange, figures; of the window composer, screen, view,
link_state, layout, controls, toolbar, notice, self_view, self_picture.
"""
