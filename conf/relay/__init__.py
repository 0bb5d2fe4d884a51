"""Run a relay: rendezvous and relay for calls between networks that accept no calls from outside."""
