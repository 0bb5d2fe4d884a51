"""Deform a photo with the control points: the contours of the photographed face, a mesh over the photo and its warp.

Reading order: contours, photographed_face, photo_mesh, warp, motion_deadband, untangle, vertex_weights, head_views,
patch_mapping, lid_sliding.
Positions are in image heights from the image's centre, x right, y up; positions_cm in cm from the face's origin, same
axes. V is the number of vertices; the first D of them are the rows of contours.PORTRAIT_LANDMARKS.
"""
