"""Motion that is made here: action units, timed expressions, idle motion, gaze, playback."""
