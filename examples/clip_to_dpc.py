"""Write the motion of the face in a clip as a DPC file: python examples/clip_to_dpc.py CLIP OUT.dpc

`conf extract` does the same with progress, gaps filled and the neutral pose known from the first frame on.
"""

import sys
from pathlib import Path

import numpy as np

from conf.face import MotionClip, write_dpc
from conf.sender import MotionExtractor, load_canonical_face, track_clip

clip, output = map(Path, sys.argv[1:])
tracked = [(frame, face) for frame, face in track_clip(clip) if face is not None]
if not tracked:
    sys.exit(f"{clip} shows no face")

height, width = tracked[0][0].pixels.shape[:2]
extractor = MotionExtractor(load_canonical_face(), (width, height))
motion = [extractor.update(face, frame.timestamp) for frame, face in tracked]

duration = motion[-1].timestamp - motion[0].timestamp
displacements = np.stack([frame.displacements for frame in motion])
poses = np.stack([frame.pose for frame in motion])
fps = (len(motion) - 1) / duration if duration else 30.0
write_dpc(output, MotionClip(fps=fps, units="fapu", displacements=displacements, poses=poses))
print(f"{len(motion)} frames with a face at {fps:.1f} frames/s -> {output}")
