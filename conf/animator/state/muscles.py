"""Waters' muscles as the panel holds them: how far each contracts, left and right together or apart."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from conf.face.deformation.facial_muscles import MUSCLE_COURSES, SPHINCTER
from conf.face.symmetry import OTHER_SIDE

MAX_JAW = 0.45  # radians

MAX_CONTRACTION = 0.5  # a face that pulls farther tears

# The thesis's figures 4.6 and 4.11, a smile and an open mouth by muscles, and three more.
PRESETS: dict[str, tuple[dict[str, float], float]] = {
    "relaxed": ({}, 0.0),
    "smile": ({"zygomatic_major": 0.25}, 0.0),
    "open mouth": ({"depressor_labii": 0.12, "levator_labii": 0.03}, 0.18),
    "frown": ({"depressor_anguli": 0.18, "corrugator": 0.25, "frontalis_inner": 0.12}, 0.0),
    "raised brows": ({"frontalis_inner": 0.3, "frontalis_outer": 0.3}, 0.0),
    "kiss": ({SPHINCTER: 0.4}, 0.0),
}


def muscle_names(name: str) -> tuple[str, ...]:
    """Return the muscles that bear a name: two of a pair, or the one in the middle."""
    return (name,) if name == SPHINCTER else (f"{name}_l", f"{name}_r")


@dataclass(frozen=True)
class MuscleState:
    """What the panel of muscles says. Every change gives a new one.

    active : whether muscles move the face instead of radial basis functions
    contractions : muscle -> 0 relaxed to 1
    jaw : radians
    both : whether a slider moves both sides
    """

    active: bool = False
    contractions: Mapping[str, float] = field(default_factory=dict)
    jaw: float = 0.0
    symmetric: bool = True

    def contract(self, muscle: str, strength: float) -> "MuscleState":
        """Contract a muscle, and its partner if both sides go together."""
        stem, _, side = muscle.rpartition("_")
        together = self.symmetric and side in OTHER_SIDE
        names = muscle_names(stem) if together else (muscle,)
        return replace(self, contractions={**self.contractions, **dict.fromkeys(names, strength)})

    def with_preset(self, pose: str) -> "MuscleState":
        """Take one of POSES."""
        strengths, jaw = PRESETS[pose]
        contractions = {name: strength for stem, strength in strengths.items() for name in muscle_names(stem)}
        return replace(self, contractions=contractions, jaw=jaw, active=True)


MUSCLES = (*MUSCLE_COURSES, SPHINCTER)
