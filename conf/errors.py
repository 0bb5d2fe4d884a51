"""Every error a user or a peer can cause. Texts say what to do about it."""


class ConfError(Exception):
    """The user's or the machine's fault: one sentence that says what to do, printed by the command line."""


class CameraError(ConfError):
    """A camera or clip cannot be opened or has stopped."""


class ModelError(ConfError):
    """The tracker's files are missing or damaged and cannot be fetched."""


class GraphicsError(ConfError):
    """OpenGL or the window cannot be had on this machine."""


class NetworkError(ConfError):
    """A socket cannot be opened, bound or written."""


class FileFormatError(ConfError):
    """A file that cannot be read as what it should be: names the file, the line and what was expected."""

    def __init__(self, path: object, line: int | None, expected: str) -> None:
        where = f"{path}, line {line}" if line is not None else f"{path}"
        super().__init__(f"{where}: {expected}")
        self.path = str(path)
        self.line = line
        self.expected = expected


class ProtocolError(Exception):
    """The peer's fault: a datagram that breaks WIRE.md. Raised in decoding, caught in one place, counted."""
