"""What the person at this end has switched on."""

from dataclasses import dataclass


@dataclass
class LocalState:
    """The switches of one's own end of a call, changed by keys and buttons, carried out by the loop.

    camera : whether the face is to be captured and sent
    camera_fault : why there is no image though the camera is on, "" while there is nothing wrong
    microphone : whether the voice is sent
    portrait : whether images of the person may be sent
    has_microphone : whether there is one
    """

    camera: bool = True
    microphone: bool = True
    portrait: bool = False
    has_microphone: bool = True
    camera_fault: str = ""

    @property
    def shows_face(self) -> bool:
        """Whether the camera is on and works."""
        return self.camera and not self.camera_fault
