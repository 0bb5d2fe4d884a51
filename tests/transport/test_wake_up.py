import select
import threading

import pytest

from conf.transport.wake_up import WakeUp


def is_readable(flag: WakeUp) -> bool:
    return bool(select.select([flag], [], [], 0)[0])


def test_a_flag_is_readable_while_it_is_set() -> None:
    flag = WakeUp()
    assert not is_readable(flag)
    for _ in range(100_000):  # more than a socket's buffer holds: setting never blocks
        flag.set()
    assert is_readable(flag)
    flag.clear()
    assert not is_readable(flag)
    flag.clear()  # nothing to read: does not block
    flag.set()
    assert is_readable(flag)
    flag.close()


def test_another_thread_wakes_select() -> None:
    flag = WakeUp()
    thread = threading.Thread(target=flag.set)
    thread.start()
    assert select.select([flag], [], [], 10)[0]
    thread.join()
    flag.close()


def test_a_closed_flag_can_be_set_and_cleared() -> None:
    flag = WakeUp()
    flag.set()
    flag.close()
    flag.set()
    flag.clear()
    with pytest.raises(ValueError):
        is_readable(flag)
