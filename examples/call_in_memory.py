"""A sealed call between two ends in memory, without sockets: python examples/call_in_memory.py"""

import os

import numpy as np

from conf.protocol import (
    MotionFrame,
    ReceiverEndpoint,
    SenderConnection,
    SenderSession,
    SessionServer,
    StreamParameters,
    generate_code,
)  # fmt: skip

SENDER, RECEIVER = ("sender", 1), ("receiver", 2)  # addresses mean nothing to the protocol
DELAY = 0.05  # seconds, one way

code = generate_code(os.urandom)
parameters = StreamParameters(width=640, height=480, fps=15.0, points=50, fapu=(6.4, 4.5, 3.0, 5.0, 1.1))
receiver = ReceiverEndpoint(SessionServer(code, os.urandom))
sender = SenderConnection(SenderSession(code, RECEIVER, os.urandom, 0.0), parameters, 0.0)

shown = 0
for tick in range(150):  # ten seconds of simulated time
    now = tick / 15
    if sender.status(now).connected:
        displacements = np.full((50, 3), 100 * np.sin(now), np.float32)
        sender.send_frame(MotionFrame(now, displacements, np.array([0, 0, 0, 0, 0, -3.7])), now)
    for data, _ in sender.datagrams_to_send(now):
        receiver.receive_datagram(data, SENDER, now + DELAY)
    for data, _ in receiver.datagrams_to_send(now + DELAY):
        sender.receive_datagram(data, RECEIVER, now + 2 * DELAY)
    shown += sum(stream.motion.frame_at(now + DELAY) is not None for stream in receiver.streams.values())

figures = receiver.snapshot(10.0)
print(f"connected with {code}; {shown} frames shown, {figures.wire_bytes_per_frame:.0f} bytes a frame with headers")
