"""Which head each participant is drawn with, and the heads themselves."""
