from conf.render.gpu_object import GpuObject


class Part:
    def __init__(self, name: str, released: list[str]) -> None:
        self._name, self._released = name, released

    def release(self) -> None:
        self._released.append(self._name)


class Whole(GpuObject):
    def __init__(self, released: list[str]) -> None:
        self._owned = (Part("array", released), Part("buffer", released))


def test_a_with_block_releases_what_is_owned_in_order() -> None:
    released: list[str] = []
    with Whole(released) as whole:
        assert isinstance(whole, Whole) and not released
    assert released == ["array", "buffer"]
