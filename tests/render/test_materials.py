from importlib.resources import files

import pytest

from conf.render.materials import MATERIALS, SKIN, material_of


def test_an_unknown_group_is_skin() -> None:
    assert material_of("polySurface7") is SKIN
    assert material_of("skin") is SKIN


@pytest.mark.parametrize(
    "material", sorted({*MATERIALS.values(), SKIN}, key=repr), ids=lambda material: material.shader
)
def test_every_material_has_its_shader(material: object) -> None:
    assert (files("conf.render") / "shaders" / f"{getattr(material, 'shader')}.frag.glsl").is_file()  # noqa: B009
