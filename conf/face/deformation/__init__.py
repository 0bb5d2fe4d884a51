"""Deform a mesh by control points or muscles: kernels, regions, operator B, rig."""
