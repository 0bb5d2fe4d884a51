"""Load heads in a thread of their own, so that a call goes on meanwhile."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

from conf.errors import ConfError
from conf.face.deformation.face_model import FaceModel
from conf.face.head_catalogue import Head
from conf.face.prepared_face import prepared_head
from conf.render.face_renderer import PreparedMesh, prepare_mesh


@dataclass(frozen=True)
class LoadedHead:
    """A head that is ready to be drawn."""

    face: FaceModel
    prepared: PreparedMesh


def load_prepared(head: Head, /) -> LoadedHead:
    """Load a head and prepare its mesh and texture. Raises FileFormatError."""
    face = prepared_head(head)
    return LoadedHead(face, prepare_mesh(face.mesh))


class HeadLoader:
    """Loads each head once, when it is first asked for."""

    def __init__(self, load: Callable[[Head], LoadedHead] = load_prepared) -> None:
        """load : raises ConfError if a head cannot be loaded"""
        self._load = load
        self._executor: ThreadPoolExecutor | None = None
        self._loading: dict[int, Future[LoadedHead]] = {}

    def poll(self, head: Head, /) -> LoadedHead | None:
        """Return a head, None while it is being loaded, or if it cannot be."""
        if head.number not in self._loading:
            if self._executor is None:
                self._executor = ThreadPoolExecutor(1, thread_name_prefix="conf-heads")
            self._loading[head.number] = self._executor.submit(self._load, head)
        future = self._loading[head.number]
        if not future.done():
            return None
        try:
            return future.result()
        except ConfError:
            return None

    def close(self) -> None:
        """Stop loading."""
        if self._executor is not None:
            self._executor.shutdown(wait=True, cancel_futures=True)
