"""Draw each participant with a head of its own, in its own proportions.

Strategy. The first face is there from the start and is drawn while another is being loaded. Heads that several
participants share are on the graphics card once: what differs, the proportions, is added to the vertices. When a
participant's proportions become known, the head takes them on within a second.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import exp

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.face.deformation.face_model import FaceModel
from conf.face.fapu import Fapu
from conf.face.furrows import knit_brows, skin_furrows
from conf.face.head_catalogue import DEFAULT_NUMBER, HEADS, HEADS_BY_NUMBER, find_head
from conf.face.head_pose import HeadPose
from conf.face.proportions import NO_CHANGE, ProportionFields, Ratios, proportion_ratios
from conf.protocol.receive_leg import ReceiveLeg
from conf.receiver.heads.assignment import HeadAssignment
from conf.receiver.heads.loader import HeadLoader
from conf.render.camera import ViewState
from conf.render.face_renderer import FaceRenderer
from conf.render.gpu_object import GpuObject

_EASE_S = 0.35  # time constant
_STEP = 0.0005  # a smaller change of a ratio is not drawn


@dataclass(frozen=True)
class HeadOptions:
    """How participants' heads are chosen and shaped.

    loader : of other heads than the first; None to draw everybody with it
    proportions : whether heads take on those of their participants
    """

    loader: HeadLoader | None = None
    proportions: bool = True


@dataclass(frozen=True)
class Look:
    """What a participant has told of its looks.

    head : number of the head that it has chosen, 0 for none
    fapu : five distances of its neutral face, cm; None before it has told
    """

    head: int = 0
    fapu: tuple[float, ...] | None = None


def look_of(leg: ReceiveLeg, /) -> Look:
    """Return what a participant has told."""
    parameters = leg.motion.parameters
    return Look(leg.head, parameters.fapu if parameters else None)


@dataclass
class _Shape:
    """The proportions of one participant's head. sender : FAPU of its person, None before they are known"""

    ratios: Ratios
    updated_at: float
    sender: Fapu | None = None
    shift: NDArray[np.float32] | None = None
    shift_of: tuple[int, Ratios] = (0, NO_CHANGE)  # head and ratios of the shift


@dataclass(frozen=True)
class _Drawable:
    fields: ProportionFields
    renderer: FaceRenderer


class ParticipantHeads(GpuObject):
    """The heads of all participants. scale : resolution of their drawings, relative"""

    def __init__(self, ctx: moderngl.Context, face: FaceModel, options: HeadOptions) -> None:
        """Prepare the first head. face : of everybody if there is no loader, else the default head"""
        self._ctx = ctx
        self._loader = options.loader
        self._proportions = options.proportions
        self._assignment = HeadAssignment([head.number for head in HEADS])
        self._numbers: Mapping[int, int] = {}  # of the heads, by participant
        self._shapes: dict[int, _Shape] = {}
        self._drawables = {DEFAULT_NUMBER: _Drawable(ProportionFields(face), FaceRenderer(ctx, face))}
        self.scale = 1.0

    def update(self, looks: dict[int, Look], now: float, *, apart: dict[int, Look] | None = None) -> None:
        """Apply what the participants have told by now; loads at most one head on the graphics card.

        apart : looks of who is drawn beside the participants, and has the default head without a choice
        """
        apart = apart or {}
        self._assignment.update({who: look.head for who, look in looks.items()})
        self._numbers = self._assignment.heads | {who: find_head(look.head).number for who, look in apart.items()}
        self._shapes = {who: self._updated(who, look, now) for who, look in (looks | apart).items()}
        self._load(self._numbers.values())

    def version(self, participant: int) -> tuple[object, ...]:
        """Return what is equal for equal images of the same motion."""
        shape = self._shapes.get(participant)
        sender = (shape.sender,) if shape and shape.sender else ()
        return self._number(participant), shape.ratios if shape else NO_CHANGE, *sender

    def draw(
        self,
        participant: int,
        displacements: NDArray[np.float32] | None,
        pose: HeadPose,
        view: ViewState,
        framebuffer: moderngl.Framebuffer,
        *,
        furrow: float = 0.0,
    ) -> None:
        """Draw a participant's motion into the framebuffer's viewport.

        displacements : (n, 3) FAPU units; None for the neutral face
        furrow : depth of the furrows between the brows, 0 to 1
        """
        number = self._number(participant)
        drawable = self._drawables[number]
        shape = self._shapes.get(participant)
        ratios = shape.ratios if shape else NO_CHANGE
        if shape and (number, ratios) != shape.shift_of:
            shape.shift_of = number, ratios
            shape.shift = drawable.fields.shift(ratios)
        shift = shape.shift if shape else None
        drawable.renderer.scale = self.scale
        if displacements is not None:
            displacements = knit_brows(displacements, furrow)
        vertices = drawable.fields.deform(displacements, ratios, shift, sender=shape.sender if shape else None)
        furrows = skin_furrows(displacements, furrow)
        drawable.renderer.draw(vertices, pose, view, framebuffer, participant=participant, shift=shift, furrows=furrows)

    def release(self) -> None:
        if self._loader is not None:
            self._loader.close()
        for drawable in self._drawables.values():
            drawable.renderer.release()

    def _number(self, participant: int) -> int:
        """Return the number of the head to draw a participant with now."""
        number = self._numbers.get(participant, DEFAULT_NUMBER) if self._loader else DEFAULT_NUMBER
        return number if number in self._drawables else DEFAULT_NUMBER

    def _load(self, numbers: Iterable[int]) -> None:
        for number in dict.fromkeys(numbers) if self._loader else ():
            if (
                self._loader
                and number not in self._drawables
                and (loaded := self._loader.poll(HEADS_BY_NUMBER[number]))
            ):
                renderer = FaceRenderer(self._ctx, loaded.face, prepared=loaded.prepared)
                self._drawables[number] = _Drawable(ProportionFields(loaded.face), renderer)
                return

    def _updated(self, participant: int, look: Look, now: float) -> _Shape:
        """Return the shape of a participant now: what was told first is applied at once, a change eased."""
        target = proportion_ratios(look.fapu) if self._proportions and look.fapu else NO_CHANGE
        sender = Fapu(*look.fapu) if look.fapu else None
        shape = self._shapes.get(participant)
        if shape is None:
            return _Shape(target, now, sender)
        shape.sender = sender
        weight = 1 - exp(-max(now - shape.updated_at, 0.0) / _EASE_S)
        es0, ens0, mns0, mw0 = np.add(shape.ratios, weight * np.subtract(target, shape.ratios)).tolist()
        is_there = np.abs(np.subtract((es0, ens0, mns0, mw0), target)).max() < _STEP
        shape.ratios = target if is_there else (es0, ens0, mns0, mw0)
        shape.updated_at = now
        return shape
