import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from conf.face.deformation.waters_muscles import LinearMuscle, MuscleSet, Sphincter

GRID = np.stack([*np.meshgrid(np.linspace(-2, 2, 21), np.linspace(-2, 2, 21)), np.zeros((21, 21))], axis=-1)
PLANE = GRID.reshape(-1, 3)
positions = hnp.arrays(np.float64, (30, 3), elements=st.floats(-3, 3))
muscles = st.builds(
    LinearMuscle,
    st.just(np.array([0.0, 1.0, 0.0])),
    st.just(np.array([0.0, -0.5, 0.2])),
    st.floats(0.2, np.pi),
    st.floats(0.0, 1.0),
    st.floats(1.1, 2.0),
)
RING = Sphincter(np.zeros(3), np.array([[1.5, 0, 0], [0, 1.0, 0]]), depth=1.0, protrusion=0.5)


@pytest.mark.slow
@given(muscle=muscles, vertices=positions)
def test_the_falloff_is_between_0_and_1_and_0_outside(muscle: LinearMuscle, vertices: np.ndarray) -> None:
    falloff = muscle.falloff(vertices)
    assert (falloff >= 0).all() and (falloff <= 1).all()
    length = np.linalg.norm(muscle.insertion - muscle.root)
    outside = np.linalg.norm(vertices - muscle.root, axis=1) >= muscle.end * length
    assert not falloff[outside].any()


@pytest.mark.slow
@given(muscle=muscles, vertices=positions)
def test_a_full_contraction_moves_no_vertex_past_the_root(muscle: LinearMuscle, vertices: np.ndarray) -> None:
    before = np.linalg.norm(vertices - muscle.root, axis=1)
    after = np.linalg.norm(vertices + muscle.offsets(vertices) - muscle.root, axis=1)
    assert (after <= before + 1e-12).all()


def test_equations_4_16_to_4_19_at_chosen_vertices() -> None:
    muscle = LinearMuscle(np.zeros(3), np.array([1.0, 0, 0]), angle=np.pi / 2, start=0.5, end=1.5)
    inside, falling, slanted, beside = np.array([[0.4, 0, 0], [1.0, 0, 0], [0.3, 0.3, 0], [-0.3, 0.1, 0]])
    falloff = muscle.falloff(np.array([inside, falling, slanted, beside]))
    np.testing.assert_allclose(falloff, [1.0, np.cos(np.pi / 4), np.cos(np.pi / 4), 0.0])
    np.testing.assert_allclose(muscle.offsets(falling[None])[0], [-np.cos(np.pi / 4), 0, 0])


@pytest.mark.parametrize(
    ("degrees", "distance", "expected"),
    [
        (0, 1.0, 1.0),  # the axis is 2 long: full pull up to 1
        (30, 1.0, 2 * np.cos(np.pi / 6) - 1),  # (cos 30 - cos 60) / (1 - cos 60)
        (60, 1.0, 0.0),
        (90, 1.0, 0.0),
        (0, 1.5, np.cos(np.pi / 8)),  # a quarter of the way from 1 to 3
        (0, 2.0, np.cos(np.pi / 4)),
        (30, 2.0, np.cos(np.pi / 4) * (2 * np.cos(np.pi / 6) - 1)),
        (0, 3.0, 0.0),
        (0, 4.0, 0.0),
    ],
)
def test_the_pull_falls_with_the_angle_and_the_distance(degrees: float, distance: float, expected: float) -> None:
    root = np.array([1.0, -2.0, 0.5])
    muscle = LinearMuscle(root, root + np.array([0.0, 0.0, 2.0]), angle=np.pi / 3, start=0.5, end=1.5)
    angle = np.radians(degrees)
    vertex = root + distance * np.array([[np.sin(angle), 0.0, np.cos(angle)]])
    assert muscle.falloff(vertex) == pytest.approx([expected], abs=1e-12)


@pytest.mark.parametrize(
    ("arm", "expected"),
    [
        ((0.0, 0.0, 0.0), 1.0),
        ((1.0, 0.0, 0.0), 0.75**2),  # half the way to the rim: 1 - 1/4
        ((-1.0, 0.0, 0.0), 0.75**2),
        ((0.0, 0.25, 0.0), 0.75**2),
        ((0.0, 0.0, 2.0), 0.75**2),
        ((0.0, 0.0, -2.0), 0.75**2),
        ((1.0, 0.25, 0.0), 0.5**2),
        ((1.0, 0.25, 2.0), 0.25**2),
        ((2.0, 0.0, 0.0), 0.0),
        ((0.0, 0.6, 0.0), 0.0),
        ((0.0, 0.0, 4.1), 0.0),
    ],
)
def test_a_ring_is_full_at_its_centre_and_ends_at_its_half_axes(
    arm: tuple[float, float, float], expected: float
) -> None:
    centre = np.array([1.0, 2.0, 3.0])
    ring = Sphincter(centre, np.array([[2.0, 0, 0], [0, 0.5, 0]]), depth=4.0, protrusion=0.5)
    vertex = centre + np.array([arm])
    assert ring.falloff(vertex) == pytest.approx([expected])
    inwards = np.array([-arm[0], -arm[1], 0.5])
    assert ring.offsets(vertex)[0] == pytest.approx(expected * inwards)


def test_the_limits_of_a_muscle_are_possible() -> None:
    opposite = np.ones(3)
    muscle = LinearMuscle(opposite, -opposite, angle=np.pi, start=0.0)
    assert muscle.falloff(np.zeros((1, 3))) == pytest.approx([np.cos(0.5 / 1.4 * np.pi / 2)])
    with pytest.raises(ValueError, match="start and end must be"):
        LinearMuscle(opposite, -opposite, start=0.7, end=0.7)


def test_a_narrow_muscle_moves_less_than_a_wide_one() -> None:
    wide, narrow = (LinearMuscle(np.array([0, 2.0, 0]), np.zeros(3), angle=a) for a in (np.pi / 2, np.pi / 6))
    assert (narrow.falloff(PLANE) <= wide.falloff(PLANE) + 1e-12).all()
    assert np.count_nonzero(narrow.falloff(PLANE)) < np.count_nonzero(wide.falloff(PLANE)) / 2


def test_the_falloff_is_continuous() -> None:
    muscle = LinearMuscle(np.array([0.0, 1.0, 0.0]), np.zeros(3), angle=np.pi / 3, start=0.6, end=1.5)
    fine = np.stack([np.linspace(-2, 2, 20001), np.full(20001, 0.1), np.zeros(20001)], axis=1)
    assert np.abs(np.diff(muscle.falloff(fine))).max() < 1e-3
    assert np.abs(np.diff(RING.falloff(fine))).max() < 1e-3


def test_the_sphincter_contracts_and_protrudes() -> None:
    offsets = RING.offsets(PLANE)
    inside = RING.falloff(PLANE) > 0
    assert (np.einsum("ij,ij->i", offsets[:, :2], PLANE[:, :2])[inside] <= 0).all()
    assert (offsets[inside, 2] > 0).all()
    assert not offsets[~inside].any()
    assert (RING.falloff(PLANE) <= 1).all()


@pytest.mark.slow
@given(contraction=st.floats(0.0, 1.0))
def test_one_muscle_is_linear_and_a_relaxed_one_moves_nothing(contraction: float) -> None:
    face = MuscleSet({"a": LinearMuscle(np.array([0, 2.0, 0]), np.zeros(3)), "ring": RING}, PLANE)
    assert not face.contract({}).any()
    assert not face.contract({"a": 0.0, "ring": 0.0}).any()
    np.testing.assert_allclose(face.contract({"a": contraction}), contraction * face.offsets[0], atol=1e-6)


@pytest.mark.slow
@given(each=hnp.arrays(np.float32, (3, 5, 3), elements=st.floats(-2, 2, width=16)))
def test_combined_offsets_stay_within_the_limit(each: np.ndarray) -> None:
    muscles = MuscleSet(dict.fromkeys("abc", RING), np.zeros((5, 3)))
    muscles.offsets = each
    total = muscles.contract(dict.fromkeys("abc", 1.0))
    assert (np.linalg.norm(total, axis=1) <= np.sqrt((each**2).sum(axis=(0, 2))) + 1e-5).all()
    assert (np.linalg.norm(total, axis=1) <= np.linalg.norm(each.sum(axis=0), axis=1) + 1e-5).all()


def test_weights_restrict_a_muscle_to_its_vertices() -> None:
    own = (PLANE[:, 0] > 0).astype(float)
    face = MuscleSet({"ring": RING, "free": RING}, PLANE, {"ring": own})
    assert face.offsets.dtype == face.contract({"ring": 0.5}).dtype == np.float32
    np.testing.assert_allclose(face.offsets[1], RING.offsets(PLANE), atol=1e-6)
    assert not face.offsets[0][own == 0].any()
    assert face.offsets[0][own == 1].any()


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"angle": 0.0}, "angle must be"),
        ({"start": 1.5}, "start and end must be"),
        ({"insertion": np.zeros(3)}, "root and insertion must differ"),
    ],
)
def test_impossible_muscles_raise(change: dict[str, object], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        LinearMuscle(**{"root": np.zeros(3), "insertion": np.ones(3), **change})  # type: ignore[arg-type]


def test_an_unknown_muscle_raises() -> None:
    with pytest.raises(ValueError, match="got biceps"):
        MuscleSet({"ring": RING}, PLANE).contract({"biceps": 1.0})
