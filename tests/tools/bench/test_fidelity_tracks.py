import numpy as np

from conf.sender.motion.mean_face import MEAN_FACE
from conf.sender.tracking.blendshape_network import INDEX
from tools.bench.fidelity_tracks import neutral_without
from tools.train.expression import Sample

JAW, CHIN = INDEX["jawOpen"], 0


def opening(name: str, drop: float) -> Sample:
    """Return a track whose chin falls by `drop` cm with the shape of an open jaw."""
    weights = np.zeros((200, 52))
    weights[:, JAW] = np.tile([0.0, 1.0], 100)
    points = np.repeat(MEAN_FACE[None], 200, axis=0)
    points[:, CHIN, 1] -= drop * weights[:, JAW]
    return Sample(name, points, weights)


def test_what_an_expression_explains_is_learned_from_other_people() -> None:
    samples = [opening("a", 1.0), opening("b", 3.0)]
    weights, points = np.zeros(52), MEAN_FACE.copy()
    weights[JAW], points[CHIN, 1] = 1.0, MEAN_FACE[CHIN, 1] - 3.0
    found = []
    for left_out in ("a", "b"):
        neutral = neutral_without(left_out, samples)
        for i in range(20):
            neutral.update(points, weights, turn=0.0, timestamp=0.2 * i)
            neutral.blended(0.2 * i)
        found.append(float(neutral.points[CHIN, 1] - MEAN_FACE[CHIN, 1]))
    assert abs(found[0]) < 0.2  # learned from b, who drops it as far
    assert -2.2 < found[1] < -1.8  # learned from a
