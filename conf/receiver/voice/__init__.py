"""The participants' voices: decoding, concealment and stretching on the playout clock, mixing, output.

Reading order: participant_voice, voice_mixer, call_sound, voice_status.
"""
