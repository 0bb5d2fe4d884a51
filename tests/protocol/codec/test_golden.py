"""Golden payloads: an encoder that keeps no curves writes the same bytes, and they decode to the same values."""

import json

import numpy as np
import pytest

from conf.errors import ProtocolError
from conf.protocol.codec.decoder import Decoder
from tools.golden.codec import DECODED, FOLDER, decoded_values, payloads

GOLDEN = json.loads(DECODED.read_text())
PAYLOADS = {name: (FOLDER / f"codec_{name}.bin").read_bytes() for name in GOLDEN}


def test_the_encoder_writes_the_golden_payloads() -> None:
    assert {name: payload for name, (_, payload) in payloads().items()} == PAYLOADS


def test_golden_payloads_decode_to_the_golden_values() -> None:
    decoded = decoded_values({name: (GOLDEN[name]["number"], payload) for name, payload in PAYLOADS.items()})
    for name, expected in GOLDEN.items():
        assert np.allclose(decoded[name]["pose"], expected["pose"], atol=2e-6)
        assert np.allclose(decoded[name]["mean_displacement"], expected["mean_displacement"], atol=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in GOLDEN if name.endswith("_0")])
def test_a_truncated_payload_is_another_frame_or_an_error(name: str) -> None:
    """The range coder decodes nearly every string; the seal around the payload ensures that it is complete."""
    whole = Decoder().decode(PAYLOADS[name], 0)[-1]
    for size in range(len(PAYLOADS[name])):
        try:
            decoded = Decoder().decode(PAYLOADS[name][:size], 0)[-1]
        except ProtocolError:
            continue
        assert not np.array_equal(decoded.displacements, whole.displacements)
