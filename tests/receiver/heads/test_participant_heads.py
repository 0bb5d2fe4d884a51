"""Which head is drawn for whom, and in which proportions."""

from collections.abc import Iterator
from unittest.mock import Mock

import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.deformation.face_model import FaceModel
from conf.face.head_catalogue import HEADS, Head
from conf.face.proportions import MEAN_DISTANCES, NO_CHANGE
from conf.protocol.receive_leg import ReceiveLeg
from conf.receiver.heads.loader import HeadLoader, LoadedHead
from conf.receiver.heads.participant_heads import HeadOptions, Look, ParticipantHeads, look_of
from conf.render.auto_framing import FrameArea, rest_pose
from conf.render.camera import ViewState
from conf.render.face_renderer import prepare_mesh
from conf.render.window.offscreen import OffscreenWindow
from tests.support.stand_in_head import SIZE

POSE, VIEW = rest_pose(FrameArea.of(SIZE)), ViewState(stats=False)
MEAN = (*MEAN_DISTANCES, 1.0)
LONG = (6.64, 5.35, 3.05, 5.18, 1.0)


@pytest.fixture
def loader(face: FaceModel) -> Iterator[Mock]:
    """Return a loader whose heads are there at once, wider the higher their number."""

    def poll(head: Head) -> LoadedHead:
        return LoadedHead(face, prepare_mesh(face.mesh))

    yield Mock(HeadLoader, poll=Mock(side_effect=poll))


@pytest.mark.slow
def test_heads_are_loaded_when_somebody_needs_them_one_in_each_frame(
    window: OffscreenWindow, face: FaceModel, loader: Mock
) -> None:
    with ParticipantHeads(window.ctx, face, HeadOptions(loader)) as heads:
        heads.update({1: Look()}, 0.0)
        assert loader.poll.call_count == 0, "the first participant has the head that is there"
        for now in (0.1, 0.2):
            heads.update({1: Look(), 2: Look(), 3: Look(head=HEADS[-1].number)}, now)
        assert sorted(call.args[0].number for call in loader.poll.call_args_list) == [HEADS[1].number, HEADS[-1].number]
        assert [heads.version(who)[0] for who in (1, 2, 3)] == [1, 2, HEADS[-1].number]
    loader.close.assert_called_once()


@pytest.mark.slow
def test_the_first_head_is_drawn_until_another_is_loaded(window: OffscreenWindow, face: FaceModel) -> None:
    loader = Mock(HeadLoader, poll=Mock(return_value=None))
    with ParticipantHeads(window.ctx, face, HeadOptions(loader)) as heads:
        heads.update({7: Look(head=2)}, 0.0)
        assert heads.version(7) == (1, NO_CHANGE)
        window.begin()
        heads.draw(7, None, POSE, VIEW, window.framebuffer)
        assert np.ptp(window.read()) > 50


@pytest.mark.slow
def test_with_one_face_for_all_nothing_is_loaded(window: OffscreenWindow, face: FaceModel) -> None:
    with ParticipantHeads(window.ctx, face, HeadOptions()) as heads:
        heads.update({1: Look(2), 2: Look(3)}, 0.0)
        assert heads.version(1)[0] == heads.version(2)[0] == 1


@pytest.mark.slow
def test_who_is_drawn_apart_has_the_default_head_and_takes_none_away(
    window: OffscreenWindow, face: FaceModel, loader: Mock
) -> None:
    with ParticipantHeads(window.ctx, face, HeadOptions(loader)) as heads:
        heads.update({0: Look()}, 0.0, apart={-2: Look()})
        assert (heads.version(0)[0], heads.version(-2)[0]) == (1, 1)
        heads.update({0: Look()}, 0.1, apart={-2: Look(3)})
        assert (heads.version(0)[0], heads.version(-2)[0]) == (1, 3)


@pytest.mark.slow
def test_proportions_that_become_known_are_taken_on_smoothly(window: OffscreenWindow, face: FaceModel) -> None:
    with ParticipantHeads(window.ctx, face, HeadOptions()) as heads:
        heads.update({1: Look(0, MEAN)}, 0.0)
        assert heads.version(1)[1] == NO_CHANGE
        heads.update({1: Look(0, LONG)}, 0.1)
        first = heads.version(1)[1]
        heads.update({1: Look(0, LONG)}, 5.0)
        last = heads.version(1)[1]
        assert isinstance(first, tuple) and isinstance(last, tuple)
        assert 1.0 < first[1] < 1.03 < 1.06 < last[1] and last[0] == last[3] == 1.0
        images = []
        for participant in (2, 1):  # nothing is known of 2
            window.begin()
            heads.draw(participant, None, POSE, VIEW, window.framebuffer)
            images.append(window.read().astype(int))
        assert np.abs(images[0] - images[1]).max() > 20


@pytest.mark.slow
def test_a_switch_turns_proportions_off(window: OffscreenWindow, face: FaceModel) -> None:
    with ParticipantHeads(window.ctx, face, HeadOptions(proportions=False)) as heads:
        heads.update({1: Look(0, LONG)}, 0.0)
        assert heads.version(1)[1] == NO_CHANGE


def test_a_look_is_what_a_participant_has_told() -> None:
    leg = ReceiveLeg()
    assert look_of(leg) == Look()
    leg.head = 3
    leg.motion.parameters = Mock(fapu=LONG)
    assert look_of(leg) == Look(3, LONG)


@pytest.mark.slow
def test_furrows_fold_the_skin_of_a_moved_face(window: OffscreenWindow, face: FaceModel) -> None:
    still = np.zeros((CONTROL_POINT_COUNT, 3), np.float32)
    images = []
    with ParticipantHeads(window.ctx, face, HeadOptions()) as heads:
        for displacements, furrow in ((still, 0.0), (still, 1.0), (None, 1.0)):
            window.begin()
            heads.draw(1, displacements, POSE, VIEW, window.framebuffer, furrow=furrow)
            images.append(window.read().astype(int))
    assert np.abs(images[1] - images[0]).max() > 20
    np.testing.assert_array_equal(images[2], images[0])
