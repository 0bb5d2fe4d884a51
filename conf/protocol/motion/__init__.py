"""The motion stream: sending, receiving and playing out coded frames."""
