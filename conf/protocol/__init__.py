"""What goes over the wire: messages, codec, jitter buffer and the two sans-IO halves. Pure."""
