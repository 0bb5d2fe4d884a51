"""The pairing code that a receiver shows: three words and a number, easy to read out over a telephone.

For a direct call the number follows the words: acorn-tulip-river-42. All of it is secret, a password of
log2(256^3 x 100) = 30.6 bits. That is enough, as SPAKE2 lets a guess be tested only by asking the receiver, which
answers five wrong guesses a minute (flood_protection.py): a chance of one in 640 a year.

For a call over a relay the number comes first: 4711-acorn-tulip-river. It is the nameplate, by which the relay brings
the two ends together, and public. The words are secret, 24 bits, and five wrong guesses in five minutes are answered: a
chance of one in 11,700 a day. The relay key is not derived from the words, or a relay could search for them.
"""

import re
from collections.abc import Callable

NUMBERS = 100
NAMEPLATE_DIGITS = 4  # of a new nameplate: 9,000, and another is chosen if it is in use
MIN_DIGITS, MAX_DIGITS = 3, 9
FORM = "a code is three words and a number, such as acorn-tulip-river-42"
RELAY_FORM = "a code for a relay is a number and three words, such as 4711-acorn-tulip-river"

# No two words differ in one letter only or sound alike; each has four to eight letters.
WORDS = tuple(
    """
    acorn actor album alley amber ankle apple apron arena arrow aspen atlas attic autumn bacon badge bagel baker
    banjo barn basket beach beard beaver blossom bonus bottle branch bread brick bridge bronze brush bucket butter
    cabin cactus camera candle canoe canyon cargo carpet carrot castle cedar chalk cherry chimney cider cinema
    circus clover coconut coffee comet copper coral cotton cradle cricket crystal curtain daisy dancer denim desert
    diamond dinner dollar dolphin donkey dragon drawer drummer eagle echo elbow engine fabric falcon family farmer
    feather fiddle finger fire flag flute forest fossil fountain frost galaxy garden garlic ghost giant giraffe
    glacier glove gorilla gravel guitar hammer harbor hawk hazel helmet honey hotel hunter iceberg igloo island
    ivory jacket jaguar jasmine jelly jigsaw jungle kayak kennel kettle kitten koala ladder lagoon lantern lava
    legend lemon leopard lilac linen lizard lobster locket lotus lunch magnet mango maple marble market meadow melon
    meteor mirror morning muffin mushroom music napkin nectar needle nickel noodle north novel nugget nutmeg oasis
    ocean olive onion opera orange orbit orchid otter oxygen oyster paddle palace panda paper pasta peanut pebble
    pelican pencil pepper piano pigeon pillow pirate planet plum pony potato pumpkin puppet puzzle pyramid quartz
    quilt rabbit radar raven ribbon river robin rodeo rope rubber salmon sandal saturn sausage school scooter shadow
    shovel silver sketch spider spoon summer sunset swan table teapot temple tennis thunder ticket tiger timber
    toast tomato tractor tulip tunnel turtle umbrella uncle unicorn vanilla velvet village violin volcano voyage
    waffle wagon walrus window winter wolf yacht yellow yogurt zebra zigzag
    """.split()
)


def generate_nameplate(random: Callable[[int], bytes], *, digits: int = NAMEPLATE_DIGITS) -> str:
    """Return a random number without a leading zero. random : n -> n random bytes"""
    lowest = 10 ** (digits - 1)
    return str(lowest + int.from_bytes(random(8)) % (9 * lowest))


def generate_code(random: Callable[[int], bytes], *, nameplate: str = "") -> str:
    """Return a new code such as "acorn-tulip-river-42", or with a nameplate "4711-acorn-tulip-river".

    random : n -> n random bytes
    """
    number = int.from_bytes(random(12))
    number, last = divmod(number, NUMBERS)
    words = []
    for _ in range(3):
        number, word = divmod(number, len(WORDS))
        words.append(WORDS[word])
    return "-".join([nameplate, *words] if nameplate else [*words, str(last)])


def nameplate_of(code: str) -> str:
    """Return the nameplate of a code in its normal form, "" if the code is for direct calls."""
    first = code.partition("-")[0]
    return first if first.isdigit() else ""


def is_nameplate(text: str) -> bool:
    """Return whether a text is a nameplate in its normal form."""
    return re.fullmatch(rf"[1-9][0-9]{{{MIN_DIGITS - 1},{MAX_DIGITS - 1}}}", text) is not None


def is_relay_code(text: str) -> bool:
    """Return whether a text looks like a code with a nameplate, and not like the name of a host."""
    return re.fullmatch(r"\s*\d+(?:[\s,_-]+[A-Za-z]+){3}\s*", text) is not None


def normalise_code(text: str) -> str:
    """Return a code as generate_code writes it, whatever its case and whatever separates its words.

    Raises ValueError, with a message for the user, if it is neither three known words and a number below 100 nor a
    nameplate and three known words.
    """
    parts = re.findall(r"[a-z]+|[0-9]+", text.lower()) if len(text) <= 80 else []
    is_for_relay = parts[:1] != [] and parts[0].isdigit()
    if len(parts) != 4 or re.search(r"[^A-Za-z0-9\s,.;:_-]", text):
        raise ValueError(RELAY_FORM if is_for_relay else FORM)
    if is_for_relay:
        return "-".join([_nameplate(parts[0]), *map(_word, parts[1:])])
    last = parts.pop()
    words = [_word(part) for part in parts]
    if not last.isdigit() or int(last) >= NUMBERS:
        raise ValueError(f"a code ends in a number from 0 to {NUMBERS - 1}, not in {last!r}")
    return "-".join([*words, str(int(last))])


def _nameplate(digits: str) -> str:
    number = digits.lstrip("0")
    if not MIN_DIGITS <= len(number) <= MAX_DIGITS:
        raise ValueError(f"a code for a relay begins with a number of {MIN_DIGITS} to {MAX_DIGITS} digits")
    return number


def _word(word: str) -> str:
    """Return a word. Raises ValueError if it is of no code."""
    if word in WORDS:
        return word
    import difflib  # here: only errors need it, and `conf receive` must print its code at once

    close = difflib.get_close_matches(word, WORDS, n=1)
    suggestion = f": did you mean {close[0]!r}?" if close else ""
    raise ValueError(f"{word!r} is not a word of any code{suggestion}")
