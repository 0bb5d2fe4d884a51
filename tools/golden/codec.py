"""Write the golden payloads of the codec to tests/data/codec_*.bin and their decoded values to codec_golden.json.

    python tools/golden/codec.py

Run this only after an intended change of tables or syntax: both ends of a call must agree on them. The payloads are of
encoders that keep no curves, so that a better choice of components leaves them as they are.
"""

import json
import sys
from importlib import resources
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from conf.protocol.codec.decoder import Decoder
from conf.protocol.codec.encoder import Encoder
from conf.protocol.codec.model import FILE, build_models
from conf.protocol.codec.profiles import PROFILES
from tests.support.synthetic_motion import grimace, talking

FOLDER = Path(__file__).resolve().parents[2] / "tests" / "data"
DECODED = FOLDER / "codec_golden.json"
PAYLOADS = 4
ACK_DELAY = 2  # payloads


def payloads() -> dict[str, tuple[int, bytes]]:
    """Return payloads and the numbers of their first frames, by name, in decoding order."""
    with resources.files("conf.assets").joinpath(FILE).open("rb") as file, np.load(file) as arrays:
        models = build_models({name: arrays[name] for name in arrays.files})
    result = {}
    for profile in PROFILES.values():
        encoder = Encoder(profile, models)
        for position in range(PAYLOADS):
            number = position * profile.frames_per_datagram
            encoder.acknowledge(range(number - (ACK_DELAY - 1) * profile.frames_per_datagram))
            frames = talking(profile.frames_per_datagram, first=number)
            result[f"{profile.name}_{position}"] = number, encoder.encode(frames, number)
    result["grimace"] = 1000, Encoder(models=models).encode(grimace(1), 1000)
    return result


def decoded_values(coded: dict[str, tuple[int, bytes]]) -> dict[str, dict[str, Any]]:
    """Return each payload's first frame number, and the pose and mean displacement of its last frame."""
    decoder = Decoder()
    result: dict[str, dict[str, Any]] = {}
    for name, (number, payload) in coded.items():
        last = decoder.decode(payload, number)[-1]
        result[name] = {
            "number": number,
            "pose": [round(value, 6) for value in last.pose.tolist()],
            "mean_displacement": [round(value, 3) for value in last.displacements.mean(axis=0).tolist()],
        }
    return result


def main() -> None:
    """Write the files."""
    coded = payloads()
    for name, (_, payload) in coded.items():
        (FOLDER / f"codec_{name}.bin").write_bytes(payload)
    DECODED.write_text(json.dumps(decoded_values(coded), indent=1) + "\n")
    print(f"{len(coded)} payloads in {FOLDER}")


if __name__ == "__main__":
    main()
