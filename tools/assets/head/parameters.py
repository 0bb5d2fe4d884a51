"""The table of parameters of one head, read from tools/assets/heads/NAME.toml."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path

Colour = tuple[float, float, float]  # sRGB, 0 to 255

TABLES = Path(__file__).resolve().parents[1] / "heads"


@dataclass(frozen=True)
class ShapeParameters:
    """The shape of the head.

    sex, origin : weights of the macro targets, each with the sum 1
    old : weight of the old targets, the rest is young; heavy, slight : of maxweight and minweight, the rest is average
    shoulders : width of neck, shoulders and shirt, relative to those of the default head
    details : weight by name of a modelling target; "eyes/eye-..." stands for both sides, as do cheek and ears
    """

    sex: Mapping[str, float] = field(default_factory=lambda: {"male": 0.62, "female": 0.38})
    origin: Mapping[str, float] = field(default_factory=lambda: {"caucasian": 0.62, "asian": 0.23, "african": 0.15})
    old: float = 0.0
    heavy: float = 0.0
    slight: float = 0.0
    shoulders: float = 1.0
    details: Mapping[str, float] = field(
        default_factory=lambda: {
            "eyes/eye-scale-incr": 0.25,
            "mouth/mouth-angles-up": 0.18,
            "head/head-scale-vert-decr": 0.15,
            "neck/neck-scale-horiz-decr": 0.1,
        }
    )


@dataclass(frozen=True)
class SkinParameters:
    """The skin. Colours that are not given keep their relation to the tone.

    flush, freckles, lines, spots : strength of redness, freckles, wrinkles and age spots
    stubble : strength of the shadow of a shaved beard; beard : of a short beard, 0 none
    """

    tone: Colour = (218, 172, 147)
    lip: Colour | None = None
    flush: float = 1.0
    freckles: float = 0.16
    lines: float = 0.0
    spots: float = 0.0
    stubble: float = 0.17
    beard: float = 0.0


@dataclass(frozen=True)
class HairParameters:
    """The hair: its style (a key of hair.STYLES), its colours from dark to light, and that of the skin between roots.

    height : thickness relative to the default head's; hairline : rise of the hairline at the forehead, cm
    receding : rise at the temples, cm; crown : how far the hair begins below the crown, 0 not at all to 1
    seed : of the random positions of locks; roots : strength of the dark skin between the roots
    shade : brightness of the deepest hair, relative
    """

    style: str = "short"
    dark: Colour = (34, 24, 19)
    middle: Colour = (66, 46, 34)
    light: Colour = (110, 80, 56)
    root: Colour = (52, 38, 31)
    height: float = 1.0
    hairline: float = 0.0
    receding: float = 0.0
    crown: float = 0.0
    seed: int = 7
    roots: float = 0.86
    shade: float = 0.3


@dataclass(frozen=True)
class EyeParameters:
    """Irises from the pupil outwards, brows and lashes.

    brow_thickness, brow_strength, lashes : relative to the default head's
    """

    iris_inner: Colour = (128, 96, 62)
    iris_outer: Colour = (74, 62, 50)
    brow: Colour = (58, 42, 34)
    brow_thickness: float = 1.0
    brow_strength: float = 1.0
    lash: Colour = (40, 28, 23)
    lashes: float = 1.0
    liner: float = 0.0


@dataclass(frozen=True)
class HeadParameters:
    """One head. number : on the wire; about : what it looks like, in a few words"""

    number: int = 1
    about: str = ""
    shirt: Colour = (58, 66, 80)
    shape: ShapeParameters = field(default_factory=ShapeParameters)
    skin: SkinParameters = field(default_factory=SkinParameters)
    hair: HairParameters = field(default_factory=HairParameters)
    eyes: EyeParameters = field(default_factory=EyeParameters)


DEFAULT = HeadParameters()


def read_parameters(path: Path) -> HeadParameters:
    """Read a table. Raises ValueError for an unknown name or weights whose sum is not 1."""
    table = tomllib.loads(path.read_text())
    sections = {"shape": ShapeParameters, "skin": SkinParameters, "hair": HairParameters, "eyes": EyeParameters}
    values = {
        name: _section(path, sections[name], value) if name in sections else value for name, value in table.items()
    }
    parameters = _section(path, HeadParameters, values)
    assert isinstance(parameters, HeadParameters)
    for weights in (parameters.shape.sex, parameters.shape.origin):
        if abs(sum(weights.values()) - 1) > 1e-6:
            raise ValueError(f"{path}: expected weights with the sum 1, got {dict(weights)}")
    return parameters


def _section(path: Path, kind: type, values: Mapping[str, object]) -> object:
    unknown = values.keys() - {f.name for f in fields(kind)}
    if unknown:
        raise ValueError(f"{path}: unknown names {sorted(unknown)} of {kind.__name__}")
    return kind(**{name: tuple(value) if isinstance(value, list) else value for name, value in values.items()})
