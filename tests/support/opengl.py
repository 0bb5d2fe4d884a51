"""Skip what needs OpenGL where there is none, fail where there must be."""

import os
from collections.abc import Callable
from functools import wraps

import pytest

from conf.errors import GraphicsError
from conf.render.window.offscreen import create_offscreen_context


def requires_gl(test: Callable[..., None]) -> Callable[..., None]:
    """Mark a test that draws."""

    @wraps(test)
    def run(*args: object, **kwargs: object) -> None:
        try:
            create_offscreen_context().release()
        except GraphicsError:
            if os.environ.get("CONF_REQUIRE_GL") == "1":
                raise
            pytest.skip("there is no OpenGL on this machine")
        test(*args, **kwargs)

    return run
