"""Code motion over a list of losses: python examples/codec_over_losses.py

A payload is predicted only from frames that the receiver has acknowledged: a loss costs its own frames and no others.
"""

import numpy as np

from conf.face import combine_action_units
from conf.protocol import PROFILES, Decoder, Encoder, MotionFrame

LOST = [False, False, True, False, True, True, False, False] * 10

encoder, decoder = Encoder(PROFILES["live"]), Decoder()
sizes, errors = [], []
for number, lost in enumerate(LOST):
    jaw, smile = 0.5 + 0.5 * np.sin(number / 2), 0.3 + 0.3 * np.sin(number / 9)
    displacements = combine_action_units({26: jaw, 12: smile})  # (50, 3) FAPU units: jaw drop, lip corner puller
    frame = MotionFrame(number / 15, displacements, np.array([0, 0, 0, 0, 0, -3.7]))
    payload = encoder.encode([frame], number)
    sizes.append(len(payload))
    if lost:
        continue
    (decoded,) = decoder.decode(payload, number)
    encoder.acknowledge([number])  # a report of the receiver tells this
    errors.append(np.abs(decoded.displacements - displacements).mean() / np.ptp(displacements))

print(f"{np.mean(sizes):.1f} B a frame, {sum(LOST)} of {len(LOST)} payloads lost")
print(f"mean error of a received frame: {np.mean(errors):.1%} of the range of its displacements")
