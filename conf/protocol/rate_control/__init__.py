"""How much is sent: rate levels, congestion control, limits, and the send budget that joins them."""
