"""How far eyeballs, lips and teeth can go."""
