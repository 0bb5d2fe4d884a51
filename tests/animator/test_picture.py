import numpy as np

from conf.animator.look import Look
from conf.animator.picture import FacePicture
from conf.animator.player import REST_POSE
from conf.face.head import FaceModel
from tests.animator.conftest import Stage


def test_styles_follow_each_other_without_a_trace(stage: Stage, head: FaceModel) -> None:
    picture = FacePicture(stage.window.ctx, head)
    seen = []
    for look in (Look(), Look(style="regions"), Look(lights="evening"), Look(style="wireframe"), Look()):
        stage.window.begin()
        picture.draw(head.neutral, REST_POSE, look, stage.window.framebuffer)
        seen.append(stage.window.read())
    np.testing.assert_array_equal(seen[0], seen[-1])
    assert all((seen[0] != other).any(axis=2).mean() > 0.1 for other in seen[1:-1])
    picture.release()
