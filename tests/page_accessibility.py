"""What axe-core finds wrong with a page of a test's browser."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.async_api import Page

AXE = Path(__file__).parents[1] / "web" / "node_modules" / "axe-core" / "axe.min.js"
# What fades in has colours of its own meanwhile, of which axe would complain on a slow machine.
_RUN = """async () => {
  const fades = (root) => [...root.getAnimations(), ...[...root.querySelectorAll('*')].flatMap(
    ({shadowRoot}) => shadowRoot === null ? [] : fades(shadowRoot))];
  const ends = fades(document).filter(({effect}) =>
    Number.isFinite(effect?.getComputedTiming().endTime));
  await Promise.all(ends.map(({finished}) => finished.catch(() => null)));
  const {violations} = await axe.run(document, {resultTypes: ['violations']});
  return violations.flatMap(({id, nodes}) =>
    nodes.map(({target}) => `${id}: ${target.flat(9).join(' ')}`));
}"""


async def find_violations(page: Page) -> list[str]:
    """Give each element that breaks one of axe's rules, as ``rule: path of the element``."""
    if not await page.evaluate("'axe' in window"):
        assert AXE.is_file(), "no axe-core in web/node_modules: `make setup` installs it"
        await page.evaluate(AXE.read_text(encoding="utf-8"))
    found: list[str] = await page.evaluate(_RUN)
    return found
