"""A video conference for links that cannot carry video: 50 facial control points, a few bytes a frame.

For programs: `conf.face` (meshes, RBF operators, motion files), `conf.protocol` (the codec and the two sans-IO ends
of a call) and `conf.sender` (from a clip to motion). `examples/` in the repository uses all three.
"""

__version__ = "0.2.0"
