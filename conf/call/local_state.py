"""What the person at this end has switched on."""

from dataclasses import dataclass


@dataclass
class LocalState:
    """The switches of one's own end of a call, changed by keys and buttons, carried out by the loop.

    camera : whether the face is captured and sent
    microphone : whether the voice is sent
    portrait : whether images of the person may be sent
    has_microphone : whether there is one
    """

    camera: bool = True
    microphone: bool = True
    portrait: bool = False
    has_microphone: bool = True
