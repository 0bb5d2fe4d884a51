"""A parser of arguments that suggests what a mistyped command, option or choice may have meant."""

import argparse
from collections.abc import Iterable, Sequence
from typing import Any, NoReturn


class SuggestingParser(argparse.ArgumentParser):
    """An ArgumentParser whose errors about unknown words name the word that is closest.

    Its subparsers are of the same class. A namespace has the parser of its command as `parser`, if the command's
    defaults set that.
    """

    _words: Sequence[str] = ()

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse as ArgumentParser does; unknown options are errors of their command's parser."""
        options, unknown = self.parse_known_args(args, namespace)
        if unknown:
            parser: SuggestingParser = getattr(options, "parser", self)
            parser.error(parser.describe_unknown(unknown))
        return options

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse as ArgumentParser does."""
        self._words = [] if args is None else list(args)
        return super().parse_known_args(args, namespace)

    def error(self, message: str) -> NoReturn:
        """Exit with an error in one line; a mistyped option comes before the complaint that another is missing."""
        unknown = [word for word in self._words if word.startswith("-") and not self._is_known(word)]
        text = self.describe_unknown(unknown) if unknown and "required" in message else message
        self.exit(2, f"{self.prog}: error: {text} (see {self.prog} --help)\n")  # without the 14 lines of usage

    def describe_unknown(self, words: Sequence[str], /) -> str:
        """Return a text that names unknown words and what is close to the first option among them."""
        options = [word.split("=")[0] for word in words if word.startswith("-")]
        suggestion = did_you_mean(options[0], self._option_names()) if options else ""
        return f"unrecognized arguments: {' '.join(words)}{suggestion}"

    def _is_known(self, word: str) -> bool:
        """Return whether a word is an option, its beginning, or one letter with its value as in -oFILE."""
        name = word.split("=")[0]
        return any(
            option.startswith(name) or (len(option) == 2 and word[:2] == option) for option in self._option_names()
        )

    def _option_names(self) -> list[str]:
        return [name for action in self._actions for name in action.option_strings]

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        # argparse has no public way to replace the message for a value that is not among the choices
        if action.choices is not None and value not in action.choices:
            choices = [str(choice) for choice in action.choices]
            suggestion = did_you_mean(str(value), choices) or f": choose from {', '.join(choices)}"
            raise argparse.ArgumentError(action, f"invalid choice {value!r}{suggestion}")


def did_you_mean(word: str, known: Iterable[str], /) -> str:
    """Return ": did you mean 'x'?" with the known word that is closest, "" if none is close."""
    import difflib  # here: only errors need it, and `conf --help` must be fast

    close = difflib.get_close_matches(word, list(known), n=1)
    return f": did you mean {close[0]!r}?" if close else ""
