"""Mutants that the score leaves out, with the reason of each.

mutmut changes the bodies of functions only, so that constants of modules and classes are left out by nature: they are
tuning constants and tables, and their values are choices. `run.py --constants` lists them.
A mutant is left out if the line it changes contains the first text of a row and the changed line the second.
"""

# In every module. Regular expressions: the line, the changed line.
EVERYWHERE = (
    (r"^raise \w+\(f?\"", r"^raise ", "the text of an error"),
    (r"strict=True", r"zip\((?!.*strict=True)", "an internal check: both are equally long by construction"),
    (r"strict=False", r"zip\(.*(strict=None|, \))", "the default"),
)

# By module. Plain texts: part of the line, part of the changed line, the reason.
BY_MODULE: dict[str, tuple[tuple[str, str, str], ...]] = {
    "protocol/rate_control/rate_levels": (
        ("repeated: int = 0", "", "a constant of the table of levels, which is made when the module is imported"),
        ('VoiceFormat("opus", bit_rate', "", "the same"),
        ('VoiceFormat("codec2", bit_rate', "", "the same"),
    )
}
