"""The animator: a window with faces, deformers, expressions and recorded motion. It uses no network."""
