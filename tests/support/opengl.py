"""OpenGL for the tests: skip without it, or fail where CONF_REQUIRE_GL is set, as it is in CI."""

import os
from typing import NoReturn

import pytest

from conf.errors import GraphicsError
from conf.render.window.offscreen import create_offscreen_context


def skip_or_fail(reason: object) -> NoReturn:
    """Skip the test because the machine lacks what reason names; fail it instead where CONF_REQUIRE_GL is set."""
    if os.environ.get("CONF_REQUIRE_GL"):
        pytest.fail(str(reason))
    pytest.skip(str(reason))


@pytest.fixture(scope="session")
def gl() -> None:
    """Check that the machine can draw without a display; every test and fixture that draws depends on it."""
    try:
        create_offscreen_context().release()
    except GraphicsError as error:
        skip_or_fail(error)
