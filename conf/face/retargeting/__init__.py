"""Motion for other programs: ARKit blendshape weights and MPEG-4 FAP."""
