"""From landmarks to displacements: head pose, neutral pose, eye openness, smoothing."""
