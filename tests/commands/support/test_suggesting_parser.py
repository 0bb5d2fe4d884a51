import pytest

from conf.cli import main
from conf.commands.support.suggesting_parser import SuggestingParser, did_you_mean


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["recieve"], "conf: error: argument COMMAND: invalid choice 'recieve': did you mean 'receive'?"),
        (["Send", "h"], "conf: error: argument COMMAND: invalid choice 'Send': did you mean 'send'?"),
        (["fly"], "conf: error: argument COMMAND: invalid choice 'fly': choose from demo, call, receive, send"),
        (["send", "h", "--potrait"], "conf send: error: unrecognized arguments: --potrait: did you mean '--portrait'?"),
        (["receive", "--lisen=5005"], "unrecognized arguments: --lisen=5005: did you mean '--listen'?"),
        (["receive", "-listen", "5005"], "unrecognized arguments: -listen 5005: did you mean '--listen'?"),
        (["doctor", "--xyz"], "conf doctor: error: unrecognized arguments: --xyz (see conf doctor --help)\n"),
        (["doctor", "more"], "conf doctor: error: unrecognized arguments: more (see conf doctor --help)\n"),
        (["--verison"], "conf: error: unrecognized arguments: --verison: did you mean '--version'?"),
        (["export", "--emotoin", "joy", "-ojoy.jpg"], "unrecognized arguments: --emotoin: did you mean '--emotion'?"),
        (["export", "--emot", "joy"], "conf export: error: the following arguments are required: -o/--output"),
        (["send", "--", "-x", "y"], "unrecognized arguments: y (see conf send --help)\n"),
        (["send", "h", "--profile", "narow"], "argument --profile: invalid choice 'narow': did you mean 'narrow'?"),
        (["models", "x"], "conf models: error: argument what: invalid choice 'x': choose from fetch, path"),
    ],
)
def test_an_unknown_word_is_answered_with_the_closest(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as exit_:
        main(arguments)
    assert exit_.value.code == 2
    assert message in capsys.readouterr().err


def test_known_words_are_parsed() -> None:
    parser = SuggestingParser()
    parser.add_argument("--profile", choices=["live", "narrow"])
    assert parser.parse_args(["--profile", "live"]).profile == "live"


def test_words_that_are_not_close_give_no_suggestion() -> None:
    assert did_you_mean("--quux", ["--listen", "--code"]) == ""
    assert did_you_mean("--liste", ["--listen", "--code"]) == ": did you mean '--listen'?"
