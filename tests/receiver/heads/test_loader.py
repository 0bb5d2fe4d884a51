import threading

from conf.errors import FileFormatError
from conf.face.head_catalogue import HEADS, Head
from conf.receiver.heads.loader import HeadLoader, LoadedHead

LOADED = LoadedHead(None, None)  # type: ignore[arg-type]


def test_a_head_is_loaded_once_and_nobody_waits_for_it() -> None:
    may_go_on, loaded = threading.Event(), list[int]()

    def load(head: Head) -> LoadedHead:
        assert may_go_on.wait(10)
        loaded.append(head.number)
        return LOADED

    loader = HeadLoader(load)
    assert loader.poll(HEADS[1]) is None and loader.poll(HEADS[1]) is None
    may_go_on.set()
    loader.close()  # waits for the thread
    assert loader.poll(HEADS[1]) is LOADED and loaded == [HEADS[1].number]


def test_a_head_that_cannot_be_loaded_never_comes() -> None:
    def load(head: Head) -> LoadedHead:
        raise FileFormatError(head.path, None, "expected a head")

    loader = HeadLoader(load)
    assert loader.poll(HEADS[1]) is None
    loader.close()
    assert loader.poll(HEADS[1]) is None


def test_without_a_head_there_is_no_thread() -> None:
    before = threading.active_count()
    loader = HeadLoader()
    assert threading.active_count() == before
    loader.close()
