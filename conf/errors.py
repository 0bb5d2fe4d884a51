"""Every error that a user or a peer can cause. The messages say what to do about it."""


class ConfError(Exception):
    """An error of the user or the machine; the command line prints its message, one sentence that says what to do."""


def explain(error: ConfError, /) -> str:
    """Return the message with its notes, which name files that were being written."""
    return "; ".join((str(error), *getattr(error, "__notes__", ())))


class CameraError(ConfError):
    """A camera or clip cannot be opened or has stopped."""


class AudioError(ConfError):
    """A sound device, a sound library or a voice codec is not available."""


class ModelError(ConfError):
    """The tracker's files are missing or damaged and cannot be downloaded."""


class GraphicsError(ConfError):
    """OpenGL or a window is not available on this machine."""


class NetworkError(ConfError):
    """A socket cannot be opened, bound or written to."""


class RecordingError(ConfError):
    """An image, clip or recording cannot be written."""


class FileFormatError(ConfError):
    """A file does not have the expected format; the message names the file, the line and what was expected."""

    def __init__(self, path: object, line: int | None, expected: str) -> None:
        position = f"{path}, line {line}" if line is not None else f"{path}"
        super().__init__(f"{position}: {expected}")
        self.path = str(path)
        self.line = line
        self.expected = expected


class ProtocolError(Exception):
    """An error of the peer: a datagram that breaks WIRE.md. Raised in decoding, caught in one place, counted."""
