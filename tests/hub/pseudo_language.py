"""A language that nobody speaks: what pages still say in English, and what is wider than its page.

The browser asks for the words of Catalan and is given, instead of them, each text of the catalogue
with an accent on each vowel, in brackets, and longer by 30 %. No build has that language. A word
with a vowel and no accent then came from nowhere in the catalogue: it is data, a name, or a fault.
"""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

from patience import PATIENCE_S

ROOT = Path(__file__).parents[2]
WEB = ROOT / "web"
_STAR = re.compile(r"^([^|\n]+)\|", re.MULTILINE)
# Which of them are up depends on the hour.
STARS = frozenset(
    word
    for name in _STAR.findall((WEB / "src/sky/bright-stars.ts").read_text(encoding="utf-8"))
    for word in name.split()
)
# What stands on a page without being a text of it, each with the reason.
NAMES = STARS | frozenset(
    {
        # The product, a button that is called so everywhere, and what is on keys.
        "Talaia", "STOP", "Esc", "Shift", "Space", "Enter",
        # Languages call themselves.
        "English", "Català", "Español",
        # Programs, formats and protocols.
        "UTC", "SQLite", "Chrome", "Linux", "Mozilla", "AppleWebKit", "KHTML", "like", "Gecko",
        "HeadlessChrome", "Safari", "rosbridge",
        # Rights and roles: so called in the description and on the command line, too.
        "admin", "view", "use", "guest", "operator", "metrics", "request", "approve", "arm", "tap",
        "unblurred",
        # Units, coordinates and zones.
        "kPa", "MPa", "mbar", "bar", "psi", "inHg", "nmi", "arcmin", "rad", "mag", "mas", "min",
        "Dec", "CET", "CEST", "GMT",
        # Dates are those of Catalan, whose place the language takes.
        "del", "nov", "des", "gen", "febr", "març", "abr", "maig", "juny", "jul", "set", "oct",
        # What the hub says: the word of a version, an alarm that it makes by itself, a name that
        # the description would give, and what a gateway does without its hub.
        "version", "Gateway", "silent", "first", "seen", "CLOSED", "NOT", "agv", "after", "then",
    }
)  # fmt: skip
# Texts and names of what a person can see, also within shadow roots, each once.
SAID = """() => {
  const found = new Set();
  const unread = new Set(['STYLE', 'SCRIPT', 'CODE', 'PRE', 'KBD', 'SAMP', 'TEMPLATE']);
  const read = ['aria-label', 'title', 'placeholder', 'alt', 'aria-valuetext'];
  const keep = text => {
    const said = (text ?? '').replace(/\\s+/g, ' ').trim();
    if (said) found.add(said);
  };
  const look = root => {
    for (const node of root.childNodes) {
      if (node.nodeType === Node.TEXT_NODE) { keep(node.data); continue; }
      if (node.nodeType !== Node.ELEMENT_NODE || unread.has(node.tagName)) continue;
      if (!['OPTION', 'SLOT'].includes(node.tagName) && !node.checkVisibility()) continue;
      for (const name of read) keep(node.getAttribute(name));
      look(node);
      if (node.shadowRoot) look(node.shadowRoot);
    }
  };
  look(document.body);
  return [...found];
}"""
ACCENTS = str.maketrans("aeiouyAEIOUY", "áéíóúýÁÉÍÓÚÝ")
WIDTH = "document.documentElement.scrollWidth"


def pseudo_module() -> str:
    """Make the module of the language's words."""
    return subprocess.run(
        ["node", "catalogue/pseudo.mjs"],
        cwd=WEB, capture_output=True, text=True, timeout=PATIENCE_S, check=True,
    ).stdout  # fmt: skip


async def speak_pseudo(context) -> None:
    """Let pages of a browser's context speak it; before any is opened."""
    words = pseudo_module()

    async def give(route) -> None:
        body = words if "/first-" in route.request.url else "export const templates = {};"
        await route.fulfill(body=body, content_type="text/javascript")

    await context.route(re.compile(r"/assets/(first|rest)-[^/]+\.js$"), give)
    await context.add_init_script("localStorage.setItem('talaia.language', 'ca')")


def english_of(said: list[str], data: set[str]) -> list[str]:
    """Give the texts with a word that the language did not touch, which is no data and no name."""
    known = data | NAMES
    return [
        text for text in said if any(plain(word) and word not in known for word in words_of(text))
    ]


def words_of(text: str) -> list[str]:
    """Split a text into its words; what has a dot, a slash, an underscore or a digit is none."""
    return re.findall(r"[^\W\d_]+", re.sub(r"\S*[./_@:]\S*\w|\S*\d\S*", " ", text))


def plain(word: str) -> bool:
    """Say whether a word has the letters of English alone."""
    return len(word) > 2 and word.isascii() and re.search("[aeiouyAEIOUY]", word) is not None
