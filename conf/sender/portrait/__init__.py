"""Make the caller's portrait: choose a photograph, cut the person out, add patches for what mouth and eyes do."""
