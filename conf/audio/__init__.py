"""Sound: voice codecs, processing, time stretching, mixing, devices. 16 kHz mono int16 inside the program.

Everything is pure but `devices`: times come with the samples, random numbers from a generator. The native libraries
(libopus, libcodec2, WebRTC's audio processing, miniaudio) are imported when they are first used; where one is missing,
AudioError says in one sentence what does not work.
"""
