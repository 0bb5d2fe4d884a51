"""What the ends of a call say about their persons: name and camera."""
