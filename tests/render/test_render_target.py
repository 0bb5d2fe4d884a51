import numpy as np
import pytest

from conf.render.render_target import BACKDROPS, RenderTarget, paint_background, sample_background
from conf.render.window.offscreen import OffscreenWindow
from tests.support.stand_in_head import SIZE


@pytest.mark.slow
def test_the_default_background_is_dark_and_smooth() -> None:
    wall = paint_background((640, 480))[..., :3].astype(int)
    assert wall.max() <= BACKDROPS["wall"].max() + 1
    blurred = wall.reshape(48, 10, 64, 10, 3).mean(axis=(1, 3))
    assert np.abs(np.diff(blurred, axis=0)).max() < 4 and np.abs(np.diff(blurred, axis=1)).max() < 4
    assert blurred[24, 32].sum() > blurred[0, 0].sum()


@pytest.mark.slow
def test_an_empty_target_resolves_to_its_background(window: OffscreenWindow) -> None:
    target = RenderTarget(window.ctx, SIZE)
    window.begin()
    target.begin()
    target.resolve(window.framebuffer)
    target.release()
    np.testing.assert_array_equal(window.read(), paint_background(SIZE)[::-1, :, 2::-1])


def test_a_hard_edge_is_anti_aliased_and_uniform_areas_are_unchanged(window: OffscreenWindow) -> None:
    """A white triangle with a shallow slope: grey along its edge, white inside."""
    target = RenderTarget(window.ctx, SIZE)
    program = window.ctx.program(
        vertex_shader="""#version 330
        const vec2 CORNERS[3] = vec2[](vec2(-0.8, -0.8), vec2(0.8, -0.8), vec2(0.8, -0.4));
        void main() { gl_Position = vec4(CORNERS[gl_VertexID], 0, 1); }""",
        fragment_shader="#version 330\nout vec4 c; void main() { c = vec4(1); }",
    )
    window.begin()
    target.begin()
    window.ctx.enable_only(window.ctx.NOTHING)
    window.ctx.vertex_array(program, []).render(vertices=3)
    target.resolve(window.framebuffer)
    grey = window.read().max(axis=2)
    target.release()
    columns = grey[:, 80:240]
    assert ((columns > 80) & (columns < 230)).sum(axis=0).mean() > 0.5  # most columns cross the edge through a grey
    assert (grey[200:212, 200:280] == 255).all()


def test_a_smaller_target_is_enlarged_into_its_viewport_only(window: OffscreenWindow) -> None:
    x, y, width, height = viewport = (40, 20, 200, 160)
    target = RenderTarget(window.ctx, (100, 80), "light", full_size=(width, height))
    window.begin()
    window.framebuffer.viewport = viewport
    target.begin()
    target.resolve(window.framebuffer, [(10, 10, 50, 30)])
    window.framebuffer.viewport = (0, 0, *SIZE)
    target.release()
    pixels = window.read()[::-1].astype(int)
    inside = pixels[y : y + height, x : x + width]
    expected = paint_background((width, height), "light")[..., 2::-1]
    assert np.abs(inside - expected).max() <= 4
    inside[:] = 0
    assert not pixels.any()


@pytest.mark.slow
def test_a_background_with_fewer_pixels_keeps_its_colours_and_its_dither() -> None:
    full, small = paint_background((640, 480)).astype(int), sample_background((320, 240), (640, 480), "wall")
    np.testing.assert_array_equal(small, full[::2, ::2])
