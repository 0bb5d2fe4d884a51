from dataclasses import replace

import numpy as np
import pytest

from conf.face.default_head import DEFAULT_HEAD
from conf.face.deformation.face_model import FaceModel
from conf.face.formats.mtl import MeshMaterial
from conf.face.mesh.mesh import load_mesh
from conf.render.materials import TRANSLUCENT
from conf.render.preparation.transparency import separate_transparent, with_transparent_parts
from conf.render.textures import MeshImages
from conf.render.window.offscreen import OffscreenWindow
from tests.render.test_face_renderer import pose, rendered
from tests.render.test_textures import plain, with_materials


@pytest.mark.slow
def test_a_part_is_transparent_by_its_alpha_and_not_by_its_name(window: OffscreenWindow, face: FaceModel) -> None:
    """The hair, renamed, is drawn as before if its image is transparent; the skin is drawn opaque."""
    clear = MeshMaterial(image=plain((0, 0, 0, 0)))
    renamed = {"hair": "polySurface7"} | {name: name for name in face.mesh.groups if name != "hair"}
    mesh = replace(face.mesh, groups={renamed[name]: rows for name, rows in face.mesh.groups.items()})
    coverage = np.concatenate([np.zeros((1, 2, 4), np.uint8), np.full((1, 2, 4), 255, np.uint8)])
    mesh = replace(mesh, uvs=np.full((len(mesh.render_vertices), 2), 0.75))
    mesh = with_materials(mesh, replace(clear, image=coverage), of={"polySurface7": 0})
    separate = separate_transparent(mesh, MeshImages(mesh))
    assert separate.groups[TRANSLUCENT].tolist() == mesh.groups["polySurface7"].tolist()
    bald = replace(face.mesh, groups={name: rows for name, rows in face.mesh.groups.items() if name != "hair"})
    bald = replace(bald, triangles=np.delete(bald.triangles, face.mesh.groups["hair"], 0),
                   render_triangles=np.delete(bald.render_triangles, face.mesh.groups["hair"], 0))  # fmt: skip
    hairless = rendered(window, replace(face, mesh=bald), pose()).astype(int)
    np.testing.assert_allclose(rendered(window, replace(face, mesh=mesh), pose()), hairless, atol=3)


@pytest.mark.parametrize(
    ("material", "blended"),
    [
        (MeshMaterial(alpha=0.5), True),
        (MeshMaterial(alpha=0.0), False),  # nothing would be visible
        (MeshMaterial(image=plain((9, 9, 9, 120))), False),  # gloss
        (MeshMaterial(image=plain((9, 9, 9, 120)), has_alpha=True), True),
        (MeshMaterial(image=plain((9, 9, 9, 0))), False),  # an alpha channel that was never filled
        (MeshMaterial(image=plain((9, 9, 9, 0)), has_alpha=False), False),
        (MeshMaterial(image=plain((9, 9, 9, 255))), False),
    ],
)
def test_which_alpha_makes_a_part_transparent(face: FaceModel, material: MeshMaterial, blended: bool) -> None:
    every = {name: 0 for name in face.mesh.groups}
    mesh = with_materials(replace(face.mesh, groups={"a": np.arange(len(face.mesh.triangles))}), material, of={"a": 0})
    assert every and (TRANSLUCENT in separate_transparent(mesh, MeshImages(mesh)).groups) is blended


@pytest.mark.slow
def test_the_hair_of_the_default_head_is_found_without_its_names() -> None:
    head = load_mesh(DEFAULT_HEAD)
    mesh = replace(head, groups={f"{name}_Mesh.001": rows for name, rows in head.groups.items()})
    found = separate_transparent(mesh, MeshImages(mesh)).groups[TRANSLUCENT]
    np.testing.assert_array_equal(found, np.union1d(head.groups["hair"], head.groups["lashes"]))
    assert with_transparent_parts(head) is head, "its names say so"
