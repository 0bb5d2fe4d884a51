"""Probes of new addresses: few, unpredictable, answered by their token only."""

from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.session.paths.validation import (
    CANDIDATE_LIFE_S,
    MAX_CANDIDATES,
    PATH_ANSWER,
    PATH_PROBE,
    PER_SECOND,
    PROBE_INTERVAL_S,
    TOKEN_BYTES,
    PathValidation,
)
from tests.support.simulated_sessions import seeded

NEW = ("198.51.100.77", 40001)


def paths() -> PathValidation:
    return PathValidation(seeded("paths"))


def answer(probe: bytes | None) -> bytes:
    assert probe is not None
    answered = paths().answer_to(probe, 0.0)
    assert answered is not None
    return answered


def test_the_answer_repeats_the_token() -> None:
    probe = paths().probe(NEW, 0.0)
    assert probe is not None and probe[0] == PATH_PROBE and len(probe) == 1 + TOKEN_BYTES
    assert answer(probe) == bytes((PATH_ANSWER,)) + probe[1:]
    assert paths().answer_to(probe[:-1], 0.0) is paths().answer_to(b"", 0.0) is paths().answer_to(b"\x80", 0.0) is None


def test_an_address_is_probed_again_after_an_interval_with_the_same_token() -> None:
    side = paths()
    first = side.probe(NEW, 0.0)
    assert side.probe(NEW, PROBE_INTERVAL_S - 0.01) is None
    assert side.probe(NEW, PROBE_INTERVAL_S) == first
    assert side.probe(NEW, CANDIDATE_LIFE_S) not in (first, None)
    assert side.validated_by(answer(first), CANDIDATE_LIFE_S) is None, "its token is forgotten"


def test_an_answer_validates_its_address_once() -> None:
    side = paths()
    probes = {address: side.probe(address, 0.0) for address in (NEW, ("b", 2))}
    assert side.validated_by(answer(probes[NEW]), 0.1) == NEW
    assert side.validated_by(answer(probes[NEW]), 0.1) is side.validated_by(answer(probes["b", 2]), 0.1) is None


def test_an_answer_after_the_life_of_a_candidate_comes_too_late() -> None:
    side = paths()
    probe = side.probe(NEW, 0.0)
    assert side.validated_by(answer(probe), CANDIDATE_LIFE_S) is None


def test_few_addresses_are_probed_at_a_time_and_few_probes_are_sent() -> None:
    side = paths()
    probes = [side.probe((f"host {number}", 1), 0.0) for number in range(100)]
    assert sum(probe is not None for probe in probes) == PER_SECOND
    assert len({probe for probe in probes if probe}) == PER_SECOND, "each with its own token"
    last = int(PER_SECOND) - 1
    assert side.validated_by(answer(probes[last - MAX_CANDIDATES]), 0.1) is None
    assert side.validated_by(answer(probes[last]), 0.1) == (f"host {last}", 1)


@given(st.binary(max_size=12))
def test_any_other_body_is_nothing_of_path_validation(body: bytes) -> None:
    side = paths()
    side.probe(NEW, 0.0)
    assert side.validated_by(bytes((PATH_ANSWER,)) + body, 0.1) is None
    if body[:1] not in (bytes((PATH_PROBE,)), bytes((PATH_ANSWER,))):
        assert side.answer_to(body, 0.1) is side.validated_by(body, 0.1) is None
