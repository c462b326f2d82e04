/** Colours and type of the tokens, as a canvas needs them. */

const SERIES = 8;
const DASHES: readonly (readonly number[])[] = [[], [7, 3], [2, 3]];

export interface Palette {
  readonly text: string;
  readonly muted: string;
  readonly line: string;
  readonly stale: string;
  readonly surface: string;
  readonly raised: string;
  readonly bad: string;
  readonly font: string;
  readonly series: readonly string[];
}

export function readPalette(element: Element): Palette {
  const style = getComputedStyle(element);
  const token = (name: string): string => style.getPropertyValue(`--t-${name}`).trim();
  return {
    text: token("text"),
    muted: token("muted"),
    line: token("line"),
    stale: token("stale"),
    surface: token("surface"),
    raised: token("raised"),
    bad: token("bad"),
    font: token("font") || "sans-serif",
    series: Array.from({ length: SERIES }, (_, i) => token(`series-${String(i + 1)}`)),
  };
}

/** The colour of a series; they come round again after eight. */
export function seriesColour(palette: Palette, index: number): string {
  return palette.series[index % SERIES] ?? palette.text;
}

/** How a series is dashed, in CSS pixels: once round the colours, the next eight must look another way. */
export function seriesDash(index: number): readonly number[] {
  return DASHES[Math.floor(index / SERIES) % DASHES.length] ?? [];
}

/** Calls `changed` when the theme does, by choice or by the machine. Returns the way to end it. */
export function watchTheme(changed: () => void): () => void {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const seen = new MutationObserver(changed);
  seen.observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme"] });
  dark.addEventListener("change", changed);
  return () => {
    seen.disconnect();
    dark.removeEventListener("change", changed);
  };
}
