"""The thesis's animator: a window over faces, deformers, emotions and recorded motion. No network."""
