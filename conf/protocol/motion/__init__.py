"""The motion stream: send, receive and play out coded frames."""
