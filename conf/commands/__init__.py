"""What the commands do, one module each. They return values and raise; only cli.py prints."""
