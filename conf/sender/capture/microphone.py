"""The microphone as a sound source: captured blocks on the clock of the frames."""

from conf.audio.devices import open_microphone
from conf.audio.samples import AudioBlock


class MicrophoneSource:
    """An open microphone."""

    def __init__(self, device: str | None = None) -> None:
        """Open it. device : number or name as `conf devices` lists them, None for the default. Raises AudioError."""
        self._device = open_microphone(device)

    def read(self, until: float, /) -> list[AudioBlock]:
        """Return what was captured since the last call; `until` is now. Raises AudioError if the device is gone."""
        block = self._device.read()
        return [] if block is None else [block]

    def close(self) -> None:
        """Stop and release it."""
        self._device.close()
