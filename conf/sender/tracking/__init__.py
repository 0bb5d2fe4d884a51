"""From a frame to landmarks: detector, landmark and blendshape networks, and their files."""
