"""The caller's voice: sound sources, framing on the stream clock, activity and coding."""
