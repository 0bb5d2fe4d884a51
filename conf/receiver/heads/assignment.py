"""Assign a head to each participant: the one that it has chosen, else one that nobody else has."""

from collections import Counter
from collections.abc import Mapping, Sequence


class HeadAssignment:
    """Assigns heads; a participant without a choice keeps its head for the whole call.

    heads : number of each head by participant, as of the last update
    """

    def __init__(self, numbers: Sequence[int]) -> None:
        """numbers : of the heads that exist, in the order in which they are given away; the first is the default"""
        self.heads: dict[int, int] = {}
        self._numbers = tuple(numbers)
        self._given: dict[int, int] = {}  # to participants without a choice

    def update(self, choices: Mapping[int, int], /) -> None:
        """Assign a head to each participant.

        choices : by participant the number of the head that it has chosen, 0 for none; an unknown one is the default
        """
        self._given = {who: head for who, head in self._given.items() if choices.get(who) == 0}
        chosen = {who: self._known(number) for who, number in choices.items() if number}
        uses = Counter([*chosen.values(), *self._given.values()])
        for who, number in choices.items():
            if not number and who not in self._given:
                self._given[who] = min(self._numbers, key=lambda head: uses[head])
                uses[self._given[who]] += 1
        self.heads = chosen | self._given

    def _known(self, number: int) -> int:
        return number if number in self._numbers else self._numbers[0]
