"""A photograph that moves: the contours of the photographed face, the mesh over it and the warp. Pure.

Reading order: contours, shape, mesh, warp, settle, unfold, beyond, sprite.
"""
