"""The usher: shows clients to their seats by the rules of `seat`, and tells everybody who sits where as it changes."""

import time
from collections.abc import Callable
from math import inf
from typing import Any

from fledge.cockpit.asks import Sticks
from fledge.cockpit.seat import Memory, Seats, Spoken
from fledge.cockpit.tells import Seating

Post = Callable[[int | None, Any], None]
"""Hands something said to a client, or to all; returns at once."""


class Usher:
    """Remembers who is there."""

    def __init__(self, post: Post) -> None:
        self._post = post
        self._rules = Seats()
        self.seating = self._rules.init()

    @property
    def silent(self) -> float | None:
        """How long nobody was heard at the sticks [s]; None if nobody ever was."""
        return time.monotonic() - self.seating.heard if self.seating.heard > -inf else None

    def come(self, client: int) -> None:
        """Somebody is there; all are told how many watch."""
        self._change(self._rules.join(self.seating, client))

    def go(self, client: int, at: float) -> None:
        """Somebody is gone."""
        self._change(self._rules.leave(self.seating, client, at))

    def ask(self, client: int, want: bool, at: float) -> None:
        """Somebody wants the seat, or not any more."""
        self._change((self._rules.ask if want else self._rules.give_up)(self.seating, client, at))

    def hear(self, client: int, sticks: Sticks, at: float) -> bool:
        """Whether somebody's sticks count."""
        before = self.seating.heard
        self._change(self._rules.hear(self.seating, client, sticks, at))
        return self.seating.heard > before

    def tick(self) -> None:
        """Time goes on."""
        self._change(self._rules.tick(self.seating, time.monotonic()))

    def say(self) -> Spoken:
        """What the supervisor hears now."""
        return self._rules.say(self.seating, time.monotonic())

    def _change(self, seating: Memory) -> None:
        before, self.seating = self.seating, seating
        if before[:3] != seating[:3]:  # clients, holder, who waits
            for client in seating.clients:
                self._post(client, self._told(client))

    def _told(self, client: int) -> Seating:
        holder = self.seating.holder
        waits = client in self.seating.waiting
        seat = "mine" if holder == client else "waiting" if waits else "free" if holder is None else "taken"
        return Seating(seat, len(self.seating.clients) - (holder is not None))
