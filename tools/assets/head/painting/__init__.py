"""Paint the texture atlas of the default head."""
