from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from conf.face.control_points import CONTROL_POINT_COUNT, CONTROL_POINT_INDEX
from conf.face.head_pose import HeadPose
from conf.protocol.portrait import NeutralPoseUpdate, ObjectReceiver, ObjectSender, Patch, Photo, decode_object
from conf.protocol.portrait.photo import MIN_LOG_SCALE
from conf.sender.portrait.photo_builder import DRAFT
from conf.sender.portrait.scheduler import BETWEEN_VIEWS_S, DRAFT_LASTS_S, FIRST_LOOK_S, PortraitScheduler
from tests.sender.portrait.test_occlusion import shaded
from tests.support.portrait_subjects import canonical, motion, shot
from tests.support.synthetic_portrait import POSE

STILL = np.zeros((CONTROL_POINT_COUNT, 3))
OPEN = STILL.copy()
OPEN[[CONTROL_POINT_INDEX[f"inner_lip_lower_{at}"] for at in ("mid", "l", "r")], 1] = -700


class Sitting:
    """A studio whose outbox is emptied without loss."""

    def __init__(self) -> None:
        self.outbox = ObjectSender(kbps=200)
        self.inbox = ObjectReceiver()
        self.studio = PortraitScheduler(canonical(), self.outbox)
        self.things: list[object] = []
        self.now = 0.0

    def sit(
        self,
        seconds: float,
        displacements: NDArray[np.float64] = STILL,
        *,
        presence: float = 1.0,
        drift: float = 0.0,
        light: float = 1.0,
    ) -> None:
        """Let frames go by, and take what comes out."""
        seen = shot(np.clip(shaded() * light, 0, 255).astype(np.uint8))
        seen = replace(seen, neutral=seen.neutral + drift)
        for _ in range(round(seconds * 15)):
            self.now += 1 / 15
            self.studio.process_frame(seen, motion(displacements), presence, self.now)
            while piece := self.outbox.next_chunk(self.now):
                if data := self.inbox.receive_chunk(piece):
                    self.things.append(decode_object(data))
            if answer := self.inbox.next_ack(self.now):
                self.outbox.receive_answer(answer)

    def count(self, kind: type) -> int:
        return sum(isinstance(thing, kind) for thing in self.things)


def test_a_draft_goes_out_soon_and_then_one_photograph_in_full() -> None:
    sitting = Sitting()
    sitting.sit(FIRST_LOOK_S + 0.9)
    (draft,) = sitting.things
    assert isinstance(draft, Photo) and len(draft.frame) <= DRAFT.max_bytes
    sitting.sit(60.0)
    assert [type(thing) for thing in sitting.things] == [Photo, Photo]


def test_after_a_draft_a_decent_frame_is_waited_for_but_not_for_ever() -> None:
    shut = STILL.copy()
    shut[[CONTROL_POINT_INDEX["eyelid_upper_l"], CONTROL_POINT_INDEX["eyelid_upper_r"]], 1] = -1024
    sitting = Sitting()
    sitting.sit(DRAFT_LASTS_S - 1, shut)
    assert sitting.count(Photo) == 1
    sitting.sit(3.0, shut)
    assert sitting.count(Photo) == 2


def test_light_that_changes_for_good_brings_a_new_photograph() -> None:
    sitting = Sitting()
    sitting.sit(BETWEEN_VIEWS_S)
    sitting.sit(10.0, light=0.6)
    assert sitting.count(Photo) == 3
    sitting.sit(30.0, light=0.6)
    assert sitting.count(Photo) == 3


def test_light_that_flickers_brings_none() -> None:
    sitting = Sitting()
    sitting.sit(BETWEEN_VIEWS_S)
    for _ in range(20):
        sitting.sit(1.0, light=0.6)
        sitting.sit(1.0)
    assert sitting.count(Photo) == 2


def test_a_new_mouth_shape_gets_one_patch() -> None:
    sitting = Sitting()
    sitting.sit(3.0)
    sitting.sit(2.0, OPEN)
    sitting.sit(1.0)
    sitting.sit(1.0, OPEN)
    patches = [thing for thing in sitting.things if isinstance(thing, Patch)]
    assert [(patch.region, patch.slot) for patch in patches] == [(0, 0)]


def test_a_neutral_pose_that_drifts_is_told() -> None:
    sitting = Sitting()
    sitting.sit(3.0)
    sitting.sit(2.5, drift=0.1)
    assert sitting.count(NeutralPoseUpdate) == 1


def test_a_poor_photograph_is_replaced_by_a_good_one_after_a_while() -> None:
    sitting = Sitting()
    shut = STILL.copy()
    shut[[CONTROL_POINT_INDEX["eyelid_upper_l"], CONTROL_POINT_INDEX["eyelid_upper_r"]], 1] = -1024
    sitting.sit(DRAFT_LASTS_S + 2, shut)
    sitting.sit(40.0)
    assert [thing.number for thing in sitting.things if isinstance(thing, Photo)] == [0, 1, 2]


def test_an_unsure_tracker_gives_no_picture() -> None:
    sitting = Sitting()
    sitting.sit(3.0, presence=0.5)
    assert not sitting.things


def test_a_face_far_away_gives_no_picture() -> None:
    sitting = Sitting()
    far = HeadPose(POSE.rotation, POSE.position, MIN_LOG_SCALE - 0.1)
    for _ in range(45):
        sitting.now += 1 / 15
        sitting.studio.process_frame(shot(shaded()), motion(pose=far), 1.0, sitting.now)
    assert sitting.outbox.waiting_bytes == 0
