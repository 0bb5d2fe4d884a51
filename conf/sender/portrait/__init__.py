"""The sender's side of the portrait: photos and patches."""
