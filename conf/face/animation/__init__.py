"""Synthetic motion: action units, timed expressions, idle motion, gaze; and playback of recorded motion."""
