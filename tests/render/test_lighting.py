import re

import pytest

from conf.render.lighting import LIGHTS, STUDIO
from conf.render.shader_programs import load_source, with_constants

NUMBER = re.compile(r"\d+\.\d+")


def values_of(name: str, text: str) -> list[float]:
    """Return a constant's numbers, multiplied by the factor after a vector."""
    body = re.search(rf"^const \w+ {name} = ([^;]+);", text, re.MULTILINE)
    assert body
    vector, _, factor = body[1].partition(" * ")
    return [float(n) * float(factor or 1) for n in re.findall(r"-?\d+\.\d+", vector)]


@pytest.mark.parametrize("name", list(STUDIO.constants()))
def test_the_studio_has_the_constants_of_the_shader_file(name: str) -> None:
    text = load_source("lighting.glsl")
    replaced = with_constants(text, STUDIO.constants())
    assert values_of(name, replaced) == pytest.approx(values_of(name, text), abs=1e-3)


@pytest.mark.parametrize("name", list(LIGHTS))
def test_only_constants_are_replaced(name: str) -> None:
    text = load_source("skin.frag.glsl")
    changed = with_constants(text, LIGHTS[name].constants())
    different = [line for line, new in zip(text.splitlines(), changed.splitlines(), strict=True) if line != new]
    assert all(line.startswith("const ") for line in different) and len(different) <= len(STUDIO.constants())
    assert with_constants(text, {}) == text
