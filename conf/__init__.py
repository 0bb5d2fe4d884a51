"""A video conference for links that cannot carry video."""
