from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.face.head_pose import HeadPose
from conf.protocol.portrait.background import Background
from conf.protocol.portrait.chunk_budget import ChunkBudget
from conf.protocol.portrait.object_receiver import ObjectReceiver
from conf.protocol.portrait.object_sender import ObjectSender
from conf.protocol.portrait.objects import decode_object, encode_object
from conf.protocol.portrait.patch import Patch
from conf.protocol.portrait.photo import MIN_LOG_SCALE, NeutralPoseUpdate, Photo
from conf.protocol.portrait.view import View
from conf.sender.motion.eye_openness import UPPER
from conf.sender.portrait import scheduler
from conf.sender.portrait.photo_builder import DRAFT
from conf.sender.portrait.photo_selection import FIRST_SEARCH_S, MAX_DRAFT_S, SCENE_INTERVAL_S
from conf.sender.portrait.scheduler import PortraitScheduler
from tests.support.drawn_person import draw_person
from tests.support.portrait_subjects import canonical, captured_face, motion, shaded_person, still
from tests.support.synthetic_portrait import POSE

OPEN, SHUT = still(), still()
OPEN[[CONTROL_POINT_INDEX[f"inner_lip_lower_{at}"] for at in ("mid", "l", "r")], 1] = -700
SHUT[UPPER, 1] = -1024


class Call:
    """A scheduler whose objects arrive without loss."""

    def __init__(self, kbps: float = 200.0) -> None:
        self.objects, self.budget = ObjectSender(), ChunkBudget(kbps)
        self.receiver = ObjectReceiver()
        self.scheduler = PortraitScheduler(canonical(), self.objects)
        self.received: list[object] = []
        self.arrivals: list[float] = []  # of the objects received, seconds
        self.now = 0.0

    def run(
        self,
        seconds: float,
        displacements: NDArray[np.float64] | None = None,
        *,
        presence: float = 1.0,
        drift: float = 0.0,
        light: float = 1.0,
        pose: HeadPose = POSE,
        pixels: NDArray[np.uint8] | None = None,
    ) -> None:
        """Process frames and receive what is sent."""
        face = captured_face(shaded_person(light) if pixels is None else pixels)
        face = replace(face, neutral=face.neutral + drift)
        for _ in range(round(seconds * 15)):
            self.now += 1 / 15
            self.scheduler.process_frame(face, motion(displacements, pose), presence, self.now)
            while chunk := self.objects.next_chunk(self.now, self.budget):
                if data := self.receiver.receive_chunk(chunk):
                    self.received.append(decode_object(data))
                    self.arrivals.append(self.now)
            if ack := self.receiver.next_ack(self.now):
                self.objects.receive_ack(ack)

    def count(self, kind: type) -> int:
        return sum(isinstance(received, kind) for received in self.received)


@pytest.mark.slow
def test_a_draft_is_followed_by_one_photo_in_full_quality() -> None:
    call = Call()
    call.run(FIRST_SEARCH_S + 0.9)
    (draft,) = call.received
    assert isinstance(draft, Photo) and len(draft.frame) <= DRAFT.max_bytes
    call.run(60.0)
    assert [type(received) for received in call.received] == [Photo, Photo]


@pytest.mark.slow
def test_each_photo_is_encoded_once(monkeypatch: pytest.MonkeyPatch) -> None:
    encoded = []

    def encode(sent: Photo | NeutralPoseUpdate | Patch) -> bytes:
        encoded.append(type(sent))
        return encode_object(sent)

    monkeypatch.setattr(scheduler, "encode_object", encode)
    call = Call()
    call.run(5.0)
    assert encoded.count(Photo) == call.count(Photo) == 2


@pytest.mark.slow
def test_a_draft_with_shut_eyes_is_replaced_after_some_time() -> None:
    call = Call()
    call.run(MAX_DRAFT_S - 1, SHUT)
    assert call.count(Photo) == 1
    call.run(4.0, SHUT)
    assert call.count(Photo) == 2


@pytest.mark.slow
def test_a_persistent_change_of_light_gives_one_new_photo() -> None:
    call = Call()
    call.run(SCENE_INTERVAL_S)
    call.run(10.0, light=0.6)
    assert call.count(Photo) == 3
    call.run(30.0, light=0.6)
    assert call.count(Photo) == 3


@pytest.mark.slow
def test_flickering_light_gives_no_new_photo() -> None:
    call = Call()
    call.run(SCENE_INTERVAL_S)
    for _ in range(20):
        call.run(1.0, light=0.6)
        call.run(1.0)
    assert call.count(Photo) == 2


@pytest.mark.slow
def test_a_new_mouth_shape_gets_one_patch() -> None:
    call = Call()
    call.run(3.0)
    call.run(2.0, OPEN)
    call.run(1.0)
    call.run(1.0, OPEN)
    patches = [received for received in call.received if isinstance(received, Patch)]
    assert [(patch.region, patch.slot) for patch in patches] == [(0, 0)]


@pytest.mark.slow
def test_the_first_view_is_built_while_the_photo_is_sent() -> None:
    call = Call(4.0)
    turned = HeadPose(POSE.rotation + np.array([0.0, 0.3, 0.0]), POSE.position, POSE.log_scale)
    for _ in range(5):
        call.run(1.0)
        call.run(1.0, pose=turned)
    kinds = [type(received) for received in call.received]
    assert kinds.count(Photo) == 2 and View in kinds
    photo, view = len(kinds) - 1 - kinds[::-1].index(Photo), kinds.index(View)
    assert call.arrivals[view] - call.arrivals[photo] < 1.6


@pytest.mark.slow
def test_what_is_behind_a_head_that_moves_aside_is_sent_once() -> None:
    call = Call()
    door = (20, 30, 90)  # BGR: behind the person, so that nothing beside tells of it
    call.run(3.0, pixels=draw_person())
    aside = HeadPose(POSE.rotation, POSE.position - (0.3, 0.0), POSE.log_scale)
    pixels = np.roll(draw_person(), -72, axis=1)
    pixels[60:140, 170:200] = door
    call.run(6.0, pose=aside, pixels=pixels)
    assert call.count(Background) == 1


@pytest.mark.slow
def test_a_neutral_pose_that_drifts_is_sent_again() -> None:
    call = Call()
    call.run(3.0)
    call.run(2.5, drift=0.1)
    assert call.count(NeutralPoseUpdate) == 1


@pytest.mark.slow
def test_a_poor_photo_is_replaced_by_a_good_one() -> None:
    call = Call()
    call.run(MAX_DRAFT_S + 2, SHUT)
    call.run(55.0)
    assert [received.number for received in call.received if isinstance(received, Photo)] == [0, 1, 2]


def test_an_uncertain_tracker_gives_no_photo() -> None:
    call = Call()
    call.run(3.0, presence=0.5)
    assert not call.received


def test_a_face_too_small_for_a_photo_is_ignored() -> None:
    call = Call()
    call.run(3.0, pose=HeadPose(POSE.rotation, POSE.position, MIN_LOG_SCALE - 0.1))
    assert not call.received and call.objects.waiting_bytes == 0
