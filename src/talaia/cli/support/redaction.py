"""Takes secrets out of texts and trees: those that are known, and what looks like one. Pure.

It masks too much rather than too little: what it lets through is sent to somebody else.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING
from urllib.parse import quote

from talaia.model.discovery.left_out_parameters import is_secret

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

__all__ = ["MASK", "Redactor", "names_secret"]

MASK = "***"
# Shorter ones are parts of words; masking them would tear every text apart.
_LEAST_KNOWN = 4
# Names of what is secret, beside those of `is_secret`, as a part of a longer name.
_NAMED = (
    r"pass(?:word|wd|phrase|code)?|pwd|secret|token|credentials?|api[_-]?key|private[_-]?key|key"
    r"|auth(?:orization)?|cookie|session(?:id)?|signature|otp|pin|seed|psk|sasl"
)
# The same as the name of a key in a tree; names of people's own things often hold *key* or *seed*.
_SECRET_PART = re.compile(
    r"(?i)(?:\A|[_.\-])(?:pass|pin|otp|psk|auth|cookie|session|signature)(?:[_.\-]|\Z)"
)
# Argument lines of programs: each word may be a secret, and no name says which.
_LINES = frozenset({"run", "prefix", "target", "command", "exec", "start", "stop", "args", "argv"})
# All that is in them is for a server alone.
_MAPS = frozenset({"headers", "env", "environment", "variables", "cookies", "auth", "query"})
_OPTION = re.compile(r"-{1,2}[A-Za-z][\w-]*")
_PLACEHOLDER = re.compile(r"\{[A-Za-z]\w*\}\Z")
# A word that somebody could have drawn at random; paths and dotted names are several words.
_RUN = re.compile(r"[A-Za-z0-9_\-+=]{20,}")
# Base64 and hexadecimal with slashes between: longer, since paths look like it.
_BASE64 = re.compile(r"(?<![\w./])[A-Za-z0-9+/]{40,}={0,2}")


def _keep_first(found: re.Match[str]) -> str:
    return f"{found.group(1)}{MASK}"


def _mask_all(_found: re.Match[str]) -> str:
    return MASK


def _mask_random(found: re.Match[str]) -> str:
    return MASK if _is_random(found.group()) else found.group()


_RULES: tuple[tuple[re.Pattern[str], Callable[[re.Match[str]], str]], ...] = (
    # To its end, or to that of the text, where a log has cut it off.
    (
        re.compile(
            r"-----BEGIN [A-Z0-9 ]*(?:PRIVATE KEY|PGP)[A-Z0-9 ]*-----.*?"
            r"(?:-----END [A-Z0-9 ]*-----|\Z)",
            re.DOTALL,
        ),
        _mask_all,
    ),
    # A password in an address may have any sign in it, also @ and /; the last @ ends it.
    (
        re.compile(r"([a-zA-Z][a-zA-Z0-9+.\-]{0,20}://)[^\s\"'<>]*@"),
        lambda m: f"{m.group(1)}{MASK}@",
    ),
    # Apprise's addresses hold their tokens as hosts and paths.
    (
        re.compile(
            r"\b((?!https?:|wss?:|file:|mqtts?:|rtsps?:|package:|sqlite:)[a-z]{3,16}://)[^\s\"'<>@]+"
        ),
        lambda m: f"{m.group(1)}{MASK}",
    ),
    (re.compile(r"([?&;#][\w.\-\[\]]+=)[^\s&;#\"'<>]+"), _keep_first),
    # Headers: all of the line.
    (
        re.compile(
            r"(?im)((?:proxy-)?authorization|(?:set-)?cookie|www-authenticate|x-[\w-]{0,40}(?:key|token)"
            r"|authentication-info)([\"']?[ \t]{0,8}[:=][ \t]{0,8})[^\n]+"
        ),
        lambda m: f"{m.group(1)}{m.group(2)}{MASK}",
    ),
    (re.compile(r"(?i)\b(bearer|basic|digest|negotiate)\s+[A-Za-z0-9+/=_.~\-]{6,}"), _mask_all),
    # name: value, name=value, "name": "value", 'name': 'two words'
    (
        re.compile(
            rf"(?i)((?:{_NAMED})[\w.\-]{{0,40}}[\"']?[ \t]{{0,8}}[:=][ \t]{{0,8}})"
            r"(?:\"(?:\\.|[^\"\\\n])*\"|'[^'\n]*'|[^\s,;}\])]+)"
        ),
        _keep_first,
    ),
    # --password value, -u user:password
    (
        re.compile(
            rf"(?i)(--[\w-]{{0,40}}(?:{_NAMED})[\w-]{{0,40}}[ =]+)"
            r"(?:\"[^\"\n]*\"|'[^'\n]*'|\S+)"
        ),
        _keep_first,
    ),
    (
        re.compile(r"((?<!\S)(?:-u|--user|-p|-P|-a)[ =]?)(?:\"[^\"\n]*\"|'[^'\n]*'|\S+)"),
        _keep_first,
    ),
    # password is hunter2, the passphrase "x y"
    (
        re.compile(
            r"(?i)\b((?:password|passphrase|secret|token|pin)(?: is| was)? )"
            r"(?:\"[^\"\n]*\"|'[^'\n]*'|[^\s,;]*\d[^\s,;]*)"
        ),
        _keep_first,
    ),
    # recovery code ABCD-1234, the verification code is 991177
    (
        re.compile(
            r"(?i)\b((?:recovery|backup|verification|one-time|sign-in|2fa|mfa) codes?"
            r"(?: is| was| are)?[ :=]{1,3})[\w-]*\d[\w-]*"
        ),
        _keep_first,
    ),
    # Forms of tokens that are known by their beginning, JSON web tokens, and Telegram's.
    (
        re.compile(
            r"\b(?:tal_|gh[opsur]_|github_pat_|glpat-|xox[abprs]-|sk[-_]|pk_|AKIA|ASIA|AIza|eyJ)"
            r"[A-Za-z0-9_\-.]{6,}"
        ),
        _mask_all,
    ),
    (re.compile(r"\b\d{6,12}:[A-Za-z0-9_\-]{20,}"), _mask_all),
    (re.compile(r"[\w.+\-]{1,64}@[\w\-]{1,64}(?:\.[\w\-]{1,64}){1,8}"), lambda _: f"{MASK}@{MASK}"),
    (_RUN, _mask_random),
    (_BASE64, _mask_random),
)


class Redactor:
    """Masks secrets; what it has masked once it masks wherever else it stands."""

    def __init__(self, known: Iterable[str] = ()) -> None:
        """Mask each of ``known`` as it stands, and as an address has it."""
        self._known: set[str] = set()
        # Longest first, so that no rest of a longer one is left.
        self._ordered: list[str] = []
        self.learn(known)

    def learn(self, secrets: Iterable[str]) -> None:
        """Mask these, too."""
        for secret in secrets:
            for line in (secret, *secret.splitlines()):
                plain = line.strip()
                if len(plain) >= _LEAST_KNOWN:
                    self._known |= {plain, quote(plain, safe="")}
        self._ordered = sorted(self._known, key=len, reverse=True)

    def clean_text(self, text: str) -> str:
        """Give a text without secrets."""
        text = self.mask_known(text)
        for pattern, masked in _RULES:
            text = pattern.sub(masked, text)
        return text

    def mask_known(self, text: str) -> str:
        """Give a text without the secrets that are known; what looks like one stays."""
        for secret in self._ordered:
            text = text.replace(secret, MASK)
        return text

    def clean_words(self, words: Iterable[str]) -> list[str]:
        """Give a program's words: its name and its options' names, and nothing else of them."""
        cleaned: list[str] = []
        for number, word in enumerate(words):
            option = _OPTION.match(word)
            if number == 0:
                cleaned.append(self.clean_text(word))
            elif option:
                rest = word[option.end() :]
                cleaned.append(option.group() + (f"={MASK}" if rest else ""))
            else:
                cleaned.append(word if _PLACEHOLDER.match(word) else MASK)
        return cleaned

    def clean_tree(self, value: object, name: str = "") -> object:
        """Give what a YAML or JSON file holds without secrets; ``name`` is the key it stands at."""
        lower = name.lower()
        if isinstance(value, dict):
            # Names of signals and devices are a person's: a device called *keys* is no secret.
            return {
                self.clean_text(str(key)): MASK
                if lower in _MAPS
                else self.clean_tree(found, str(key))
                for key, found in value.items()
            }
        if names_secret(name) and value is not None and value != "":
            return MASK
        if lower in _LINES and isinstance(value, str):
            return " ".join(self.clean_words(value.split()))
        if isinstance(value, list):
            if lower in _LINES and all(isinstance(word, str) for word in value):
                return self.clean_words(value)
            return [self.clean_tree(found, name) for found in value]
        return self.clean_text(value) if isinstance(value, str) else value

    def find_known(self, text: str) -> int:
        """Count the known secrets that still stand in a text."""
        return sum(1 for secret in self._ordered if secret in text)


def names_secret(name: str) -> bool:
    """Tell whether what stands at this name is a secret."""
    # A number may be one as well: a PIN.
    return is_secret(name) or bool(_SECRET_PART.search(name))


def _is_random(word: str) -> bool:
    """Tell a word that was drawn at random from one that people have put together."""
    parts = re.split(r"[_\-+=]", word)
    # talaia-gateway-2026_11: each part is a word or a number.
    if all(part.isalpha() or part.isdecimal() or not part for part in parts):
        return max((len(part) for part in parts if part.isalpha()), default=0) > 32
    return any(letter.isdecimal() for letter in word) and any(letter.isalpha() for letter in word)
