"""Base class of the owners of GPU objects."""

from typing import Protocol, Self


class Releasable(Protocol):
    """What frees its memory on the graphics card in `release`."""

    def release(self) -> object: ...


class GpuObject:
    """Free GPU objects in `release`, or at the end of a `with` block.

    A subclass lists the objects that it owns in `_owned`, in the order in which they are released.
    """

    _owned: tuple[Releasable, ...] = ()

    def release(self) -> None:
        """Free everything on the graphics card; the object must not be used afterwards."""
        for owned in self._owned:
            owned.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.release()
