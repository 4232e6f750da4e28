"""Which line of a TOML file a key stands in, which `tomllib` does not say."""

from __future__ import annotations

import re
import tomllib

# What may stand between tokens: blanks, line ends and comments.
GAP = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
BLANKS = re.compile(r"[ \t]*")
BARE = re.compile(r"[A-Za-z0-9_-]+")
STRING = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}|' + r"'''.*?'{3,5}" + r'|"(?:\\.|[^"\\\n])*"|' + r"'[^'\n]*'",
    re.DOTALL,
)
PLAIN = re.compile(r"[^,\]}#\n]*")  # a number, a date, true or false


def lines(text: str) -> dict[str, int]:
    """The line in which each key is first named, by its path, such as "base.rho".

    Args:
        text: a TOML file that `tomllib` reads. Keys in arrays have the array's path in front.
    """
    return _Scanner(text).found


def _plain(written: str) -> str:
    """A key without its quotes and escapes."""
    if written.startswith('"') and "\\" in written:
        return str(tomllib.loads(f"key = {written}")["key"])
    return written.strip("\"'")


class _Scanner:
    def __init__(self, text: str) -> None:
        self.text, self.at = text, 0
        self.found: dict[str, int] = {}
        section: tuple[str, ...] = ()
        while self._skip(GAP) < len(text):
            if text[self.at] == "[":
                self.at += 2 if text.startswith("[[", self.at) else 1
                section = self._key(())
                self.at = self._past("]")
                if text.startswith("]", self.at):
                    self.at += 1
            else:
                self._pair(section)

    def _skip(self, pattern: re.Pattern[str]) -> int:
        found = pattern.match(self.text, self.at)
        self.at = found.end() if found else self.at
        return self.at

    def _past(self, mark: str) -> int:
        return self.text.index(mark, self.at) + 1

    def _key(self, before: tuple[str, ...]) -> tuple[str, ...]:
        """A key that may have dots, put into the list; what is before it is its table."""
        path = before
        while True:
            self._skip(BLANKS)
            begin = self.at
            self._skip(STRING if self.text[begin] in "\"'" else BARE)
            path = (*path, _plain(self.text[begin : self.at]))
            self.found.setdefault(".".join(path), self.text.count("\n", 0, begin) + 1)
            self._skip(BLANKS)
            if not self.text.startswith(".", self.at):
                return path
            self.at += 1

    def _pair(self, before: tuple[str, ...]) -> None:
        path = self._key(before)
        self.at = self._past("=")
        self._value(path)

    def _value(self, path: tuple[str, ...]) -> None:
        self._skip(BLANKS)
        first = self.text[self.at]
        if first in "\"'":
            self._skip(STRING)
        elif first in "[{":
            self.at += 1
            while self.text[self._skip(GAP)] not in "]}":
                if first == "{":
                    self._pair(path)
                else:
                    self._value(path)
                if self.text[self._skip(GAP)] == ",":
                    self.at += 1
            self.at += 1
        else:
            self._skip(PLAIN)
