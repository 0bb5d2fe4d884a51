"""The start window: call or be called, choose devices, keep settings."""
