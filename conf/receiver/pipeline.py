"""The receiving loop: datagrams from the network, pictures to a window.

The way of one frame is read here from top to bottom; every step it calls is a module of its own.
"""

import time
from collections.abc import Callable
from typing import Protocol

import moderngl
import numpy as np
from numpy.typing import NDArray

from conf.face.head import FaceModel
from conf.face.head_pose import NEUTRAL_POSE, HeadPose
from conf.protocol.inbound import Inbound
from conf.protocol.jitter_buffer import Playout
from conf.protocol.messages import Presence
from conf.receiver.events import Event, action_of, apply
from conf.receiver.framing import Framer
from conf.receiver.meter import Meter, MeterReading
from conf.receiver.renderer import FaceRenderer
from conf.receiver.scene import View
from conf.receiver.udp import ReceiverSocket
