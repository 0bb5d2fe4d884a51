"""State of the muscles panel: contractions of Waters' muscles, of both sides together or apart."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from conf.face.deformation.facial_muscles import MUSCLE_COURSES, SPHINCTER
from conf.face.symmetry import OTHER_SIDE

MUSCLES = (*MUSCLE_COURSES, SPHINCTER)
MAX_JAW = 0.45  # rad
MAX_CONTRACTION = 0.5  # stronger contractions tear the mesh

# Contractions and jaw angle, rad. Smile and open mouth: figures 4.6 and 4.11 of the thesis.
PRESETS: dict[str, tuple[dict[str, float], float]] = {
    "relaxed": ({}, 0.0),
    "smile": ({"zygomatic_major": 0.25}, 0.0),
    "open mouth": ({"depressor_labii": 0.12, "levator_labii": 0.03}, 0.18),
    "frown": ({"depressor_anguli": 0.18, "corrugator": 0.25, "frontalis_inner": 0.12}, 0.0),
    "raised brows": ({"frontalis_inner": 0.3, "frontalis_outer": 0.3}, 0.0),
    "kiss": ({SPHINCTER: 0.4}, 0.0),
}


def muscle_names(stem: str) -> tuple[str, ...]:
    """Return the names of a pair of muscles, left first, or of the one in the middle."""
    return (stem,) if stem == SPHINCTER else (f"{stem}_l", f"{stem}_r")


@dataclass(frozen=True)
class MuscleState:
    """Immutable muscle state.

    active : whether muscles deform the face instead of radial basis functions
    contractions : muscle -> 0 relaxed to 1
    jaw : rad
    symmetric : whether a slider changes both sides
    """

    active: bool = False
    contractions: Mapping[str, float] = field(default_factory=dict)
    jaw: float = 0.0
    symmetric: bool = True

    def contract(self, muscle: str, contraction: float) -> "MuscleState":
        """Set the contraction of a muscle, and of its partner if `symmetric`."""
        stem, _, side = muscle.rpartition("_")
        names = muscle_names(stem) if self.symmetric and side in OTHER_SIDE else (muscle,)
        return replace(self, contractions={**self.contractions, **dict.fromkeys(names, contraction)})

    def with_preset(self, preset: str) -> "MuscleState":
        """Set all contractions and the jaw to those of a preset, and let muscles deform the face."""
        by_stem, jaw = PRESETS[preset]
        contractions = {name: contraction for stem, contraction in by_stem.items() for name in muscle_names(stem)}
        return replace(self, contractions=contractions, jaw=jaw, active=True)
