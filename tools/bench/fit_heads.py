"""Generate heads with known control points for mesh_fitting.py and for training.

Men, women, children and old people are blended from the targets of the base figure. All have its topology, so that the
vertex of a control point is the same in all heads. Each head is written in another format, unit and orientation.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX, CONTROL_POINT_LANDMARKS, CONTROL_POINTS
from conf.sender.tracking.canonical_face import CanonicalFace
from tools.assets.head.control_vertices import VERTICES
from tools.assets.head.source import BaseMesh, Source

FROM_Y_UP = {  # rotations from y up, z to the front
    ("y", "z"): np.eye(3),
    ("z", "-y"): np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
    ("z", "x"): np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]]),
    ("-y", "z"): np.array([[-1.0, 0, 0], [0, -1, 0], [0, 0, 1]]),
}
EYES = ("helper-l-eye", "helper-r-eye")
NECK_DM = 0.95  # distance below the eyes at which a head is cut off, for the size of an adult


@dataclass(frozen=True)
class Recipe:
    """Definition of one head and its file.

    targets : name of a modelling target -> weight; a leading `*/` means both sides
    parts : groups of the base figure that are written
    unit : length of a decimetre in the units of the file
    """

    name: str
    targets: dict[str, float]
    suffix: str = ".obj"
    parts: tuple[str, ...] = ("body", *EYES)
    unit: float = 1.0
    axes: tuple[str, str] = ("y", "z")
    whole_body: bool = False


@dataclass(frozen=True)
class Head:
    """A mesh file and the (n, 3) true positions of its control points, in the axes and unit of the file."""

    name: str
    path: Path
    truth: NDArray[np.float64]
    axes: tuple[str, str] = ("y", "z")


def macro(sex: str, age: str, **origins: float) -> dict[str, float]:
    """Return the targets of an average person of one sex and age: baby, child, young or old."""
    weights = {f"macrodetails/{origin}-{sex}-{age}": weight for origin, weight in origins.items()}
    return weights | {f"macrodetails/universal-{sex}-{age}-averagemuscle-averageweight": 1.0}


RECIPES = (
    Recipe("young_man", macro("male", "young", caucasian=1.0) | {
        "nose/nose-scale-vert-incr": 0.6, "chin/chin-width-incr": 0.7, "mouth/mouth-scale-horiz-incr": 0.5}),
    Recipe("young_woman", macro("female", "young", african=1.0) | {
        "mouth/mouth-upperlip-volume-incr": 0.6, "*/eyes/eye-scale-incr": 0.5, "nose/nose-width2-incr": 0.5},
        ".ply", unit=0.1, axes=("z", "-y")),
    Recipe("old_man", macro("male", "old", asian=1.0) | {
        "nose/nose-hump-incr": 0.8, "*/eyes/eye-bag-incr": 0.6, "head/head-rectangular": 0.7},
        ".stl", unit=100.0),
    Recipe("old_woman", macro("female", "old", caucasian=0.6, african=0.4) | {
        "mouth/mouth-angles-down": 0.6, "*/eyes/eye-height2-decr": 0.5, "head/head-oval": 0.8},
        ".glb", unit=0.1),
    Recipe("boy", macro("male", "child", african=0.5, caucasian=0.5) | {
        "head/head-round": 0.7, "nose/nose-point-up": 0.5}, parts=("body",), unit=10.0),
    Recipe("girl", macro("female", "child", asian=1.0) | {
        "*/eyes/eye-epicanthus-in": 0.4, "mouth/mouth-scale-horiz-decr": 0.5}, axes=("z", "x")),
    Recipe("heavy_man", {"macrodetails/caucasian-male-young": 0.5, "macrodetails/asian-male-young": 0.5,
        "macrodetails/universal-male-young-averagemuscle-maxweight": 1.0, "head/head-fat-incr": 0.5,
        "chin/chin-prominent-decr": 0.6}, parts=("body", *EYES, "helper-upper-teeth", "helper-lower-teeth"),
        axes=("-y", "z")),
    Recipe("thin_woman", {"macrodetails/caucasian-female-young": 1.0,
        "macrodetails/universal-female-young-averagemuscle-minweight": 1.0, "nose/nose-scale-depth-incr": 0.6,
        "mouth/mouth-lowerlip-volume-incr": 0.5, "mouth/mouth-trans-down": 0.4}, unit=254.0, whole_body=True),
)  # fmt: skip


def write_heads(source: Source, canonical: CanonicalFace, folder: Path) -> list[Head]:
    """Write every head into the folder."""
    return [*(write_head(recipe, source, folder) for recipe in RECIPES), *_write_canonical(canonical, folder)]


def random_recipe(name: str, source: Source, rng: np.random.Generator) -> Recipe:
    """Return a random person: sex, age, origin, weight, and eight exaggerated features."""
    sex, ages = rng.choice(["male", "female"]), _AGES[rng.integers(len(_AGES))]
    origin_weights = rng.dirichlet([0.7] * len(_ORIGINS))
    targets: dict[str, float] = {}
    for age in ages:
        weight = rng.choice(["averageweight", "maxweight", "minweight"], p=[0.6, 0.2, 0.2])
        targets[f"macrodetails/universal-{sex}-{age}-averagemuscle-{weight}"] = 1 / len(ages)
        for origin, origin_weight in zip(_ORIGINS, origin_weights, strict=True):
            targets[f"macrodetails/{origin}-{sex}-{age}"] = float(origin_weight) / len(ages)
    for feature in rng.choice(_FEATURES, 8, replace=False):
        targets[str(feature)] = float(rng.uniform(0.2, 0.7))
    return Recipe(name, targets, parts=("body", *EYES) if rng.random() < 0.75 else ("body",))


_AGES = (("young",), ("young", "old"), ("child", "young"), ("old",), ("child",))
_ORIGINS = ("caucasian", "asian", "african")
# Targets of single features of the base figure: folder/prefix, then the names.
_FEATURE_TABLE = """
head/head- age-decr age-incr angle-in angle-out back-scale-depth-decr back-scale-depth-incr
head/head- diamond fat-decr fat-incr invertedtriangular oval rectangular
head/head- round scale-depth-decr scale-depth-incr scale-horiz-decr scale-horiz-incr scale-vert-decr
head/head- scale-vert-incr square trans-backward trans-down trans-forward trans-up
head/head- triangular
chin/chin- bones-decr bones-incr cleft-decr cleft-incr height-decr height-incr
chin/chin- jaw-drop-decr jaw-drop-incr prognathism-decr prognathism-incr prominent-decr prominent-incr
chin/chin- triangle width-decr width-incr
nose/nose- base-down base-up compression-compress compression-uncompress curve-concave curve-convex
nose/nose- flaring-decr flaring-incr greek-decr greek-incr hump-decr hump-incr
nose/nose- nostrils-angle-down nostrils-angle-up nostrils-width-decr nostrils-width-incr point-down point-up
nose/nose- point-width-decr point-width-incr scale-depth-decr scale-depth-incr scale-horiz-decr scale-horiz-incr
nose/nose- scale-vert-decr scale-vert-incr septumangle-decr septumangle-incr trans-backward trans-down
nose/nose- trans-forward trans-up volume-decr volume-incr width1-decr width1-incr
nose/nose- width2-decr width2-incr width3-decr width3-incr
mouth/mouth- angles-down angles-up cupidsbow-decr cupidsbow-incr cupidsbow-width-decr cupidsbow-width-incr
mouth/mouth- dimples-in dimples-out laugh-lines-in laugh-lines-out lowerlip-ext-down lowerlip-ext-up
mouth/mouth- lowerlip-height-decr lowerlip-height-incr lowerlip-middle-down lowerlip-middle-up lowerlip-volume-decr
mouth/mouth- lowerlip-volume-incr
mouth/mouth- lowerlip-width-decr lowerlip-width-incr philtrum-volume-decr philtrum-volume-incr scale-depth-decr
mouth/mouth- scale-depth-incr
mouth/mouth- scale-horiz-decr scale-horiz-incr scale-vert-decr scale-vert-incr trans-backward trans-down
mouth/mouth- trans-forward trans-up upperlip-ext-down upperlip-ext-up upperlip-height-decr upperlip-height-incr
mouth/mouth- upperlip-middle-down upperlip-middle-up upperlip-volume-decr upperlip-volume-incr upperlip-width-decr
mouth/mouth- upperlip-width-incr
forehead/forehead- nubian-decr nubian-incr scale-vert-decr scale-vert-incr temple-decr temple-incr
forehead/forehead- trans-backward trans-forward
eyebrows/eyebrows- angle-down angle-up trans-backward trans-down trans-forward trans-up
*/eyes/eye- bag-decr bag-height-decr bag-height-incr bag-in bag-incr bag-out
*/eyes/eye- corner1-down corner1-up corner2-down corner2-up epicanthus-in epicanthus-out
*/eyes/eye- eyefold-angle-down eyefold-angle-up eyefold-concave eyefold-convex eyefold-down eyefold-up
*/eyes/eye- height1-decr height1-incr height2-decr height2-incr height3-decr height3-incr
*/eyes/eye- push1-in push1-out push2-in push2-out scale-decr scale-incr
*/eyes/eye- trans-down trans-up
*/cheek/cheek- bones-decr bones-incr inner-decr inner-incr trans-down trans-up
*/cheek/cheek- volume-decr volume-incr
"""
_FEATURES = [f"{row.split()[0]}{name}" for row in _FEATURE_TABLE.strip().splitlines() for name in row.split()[1:]]


def write_head(recipe: Recipe, source: Source, folder: Path) -> Head:
    """Write one head into the folder."""
    base = source.read_base()
    count = len(base.vertices)
    blended = base.vertices.copy()
    for target, weight in recipe.targets.items():
        for name in _both_sides(target):
            blended += weight * source.read_target(name, count)
    truth, eye_distance = _truth(base, blended)
    kept = np.isin(base.groups, recipe.parts)
    if not recipe.whole_body:
        lowest = truth[:, 1].max() - NECK_DM * eye_distance / 0.64 * 2.2
        kept &= blended[base.faces][..., 1].min(axis=1) > lowest
    rotation = FROM_Y_UP[recipe.axes] * recipe.unit
    used, faces = np.unique(base.faces[kept], return_inverse=True)
    path = folder / f"{recipe.name}{recipe.suffix}"
    _WRITERS[recipe.suffix](path, blended[used] @ rotation.T, faces.reshape(-1, 4))
    return Head(recipe.name, path, truth @ rotation.T, recipe.axes)


def _both_sides(target: str) -> list[str]:
    """Return `eyes/l-eye-x` and `eyes/r-eye-x` for `*/eyes/eye-x`."""
    if not target.startswith("*/"):
        return [target]
    folder, name = target[2:].split("/")
    return [f"{folder}/{side}-{name}" for side in "lr"]


def _truth(base: BaseMesh, vertices: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Return the (n, 3) control points and the distance of the pupils, which are the front of the eye helpers."""
    positions = {name: vertices[index] for name, index in VERTICES.items()}
    for side in "lr":
        eye = vertices[base.members(f"helper-{side}-eye")]
        positions[f"pupil_{side}"] = np.array([*eye.mean(axis=0)[:2], eye[:, 2].max()])
    return (
        np.array([positions[point.name] for point in CONTROL_POINTS]),
        float(np.linalg.norm(positions["pupil_l"] - positions["pupil_r"])),
    )


def _write_canonical(canonical: CanonicalFace, folder: Path) -> list[Head]:
    """Write the mean face of the tracker, a surface without openings at mouth or eyes and without a back.

    It is written twice: unchanged, and with each triangle split in four, so that its vertices are not the landmarks.
    """
    truth = canonical.vertices[np.minimum(CONTROL_POINT_LANDMARKS, len(canonical.vertices) - 1)]
    for name, ring in (("pupil_l", (263, 362, 386, 374)), ("pupil_r", (33, 133, 159, 145))):
        # The mesh has no vertex at a pupil: take the middle of the eye's outline.
        truth[CONTROL_POINT_INDEX[name]] = canonical.vertices[list(ring)].mean(axis=0)
    split = trimesh.Trimesh(canonical.vertices, canonical.triangles, process=False).subdivide()
    meshes = {"canonical": (canonical.vertices, canonical.triangles), "canonical_split": (split.vertices, split.faces)}
    for name, (vertices, triangles) in meshes.items():
        write_mesh(folder / f"{name}.obj", np.asarray(vertices), np.asarray(triangles))
    return [Head(name, folder / f"{name}.obj", truth) for name in meshes]


def write_mesh(path: Path, vertices: NDArray[np.float64], faces: NDArray[np.integer]) -> None:
    """Write an OBJ file of positions and faces only."""
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in vertices]
    lines += [f"f {' '.join(str(index + 1) for index in face)}" for face in faces]
    path.write_text("\n".join(lines) + "\n")


def _write_trimesh(path: Path, vertices: NDArray[np.float64], faces: NDArray[np.integer]) -> None:
    triangles = np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])
    trimesh.Trimesh(vertices, triangles, process=False).export(path)


_WRITERS: dict[str, Callable[[Path, NDArray[np.float64], NDArray[np.integer]], None]] = {
    ".obj": write_mesh,
    ".ply": _write_trimesh,
    ".glb": _write_trimesh,
    ".stl": _write_trimesh,
}
