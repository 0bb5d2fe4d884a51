"""Golden payloads hold the codec still: its bytes, and what they mean."""

import json

import numpy as np
import pytest

from conf.errors import ProtocolError
from conf.protocol.codec import Decoder
from tools.golden.codec import DECODED, FOLDER, decoded_values, payloads

GOLDEN = json.loads(DECODED.read_text())
PAYLOADS = {name: (FOLDER / f"codec_{name}.bin").read_bytes() for name in GOLDEN}


def test_the_encoder_still_writes_these_bytes() -> None:
    assert {name: payload for name, (_, payload) in payloads().items()} == PAYLOADS


def test_the_bytes_still_mean_the_same() -> None:
    found = decoded_values({name: (GOLDEN[name]["number"], payload) for name, payload in PAYLOADS.items()})
    for name, meaning in GOLDEN.items():
        assert np.allclose(found[name]["pose"], meaning["pose"], atol=2e-6)
        assert np.allclose(found[name]["mean_displacement"], meaning["mean_displacement"], atol=2e-3)


@pytest.mark.parametrize("name", [name for name in GOLDEN if name.endswith("_0")])
def test_a_truncated_payload_is_another_frame_or_an_error(name: str) -> None:
    """The range coder gives nearly every string a meaning: that a payload is whole, the seal around it says."""
    whole = Decoder().decode(PAYLOADS[name], 0)[-1]
    for size in range(len(PAYLOADS[name])):
        try:
            shown = Decoder().decode(PAYLOADS[name][:size], 0)[-1]
        except ProtocolError:
            continue
        assert not np.array_equal(shown.displacements, whole.displacements)
