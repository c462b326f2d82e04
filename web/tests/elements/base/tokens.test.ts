import { readFileSync } from "node:fs";
import { describe, expect, test } from "vitest";

const css = readFileSync(new URL("../../../src/elements/base/tokens.css", import.meta.url), "utf8");

type Tokens = Readonly<Record<string, string>>;

function blocks(): Tokens[] {
  return [...css.matchAll(/:root[^{]*\{([^{}]*)\}/g)]
    .map((match) =>
      Object.fromEntries(
        [...(match[1] ?? "").matchAll(/(--t-[a-z0-9-]+):\s*(#[0-9a-f]{6})/g)].map((pair) => [pair[1] ?? "", pair[2] ?? ""]),
      ),
    )
    .filter((tokens) => "--t-bg" in tokens);
}

/** Relative luminance, WCAG 2.2. */
function luminance(colour: string): number {
  const [r = 0, g = 0, b = 0] = [1, 3, 5].map((at) => {
    const part = parseInt(colour.slice(at, at + 2), 16) / 255;
    return part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

function contrast(a: string, b: string): number {
  const [low = 0, high = 0] = [luminance(a), luminance(b)].sort((x, y) => x - y);
  return (high + 0.05) / (low + 0.05);
}

const [light, dark, autoDark, night] = blocks();
const themes: Record<string, Tokens | undefined> = { light, dark, night };
const texts = ["text", "muted", "accent", "ok", "warn", "bad", "stale", "info"];
const backgrounds = ["bg", "surface", "raised"];
const series = [1, 2, 3, 4, 5, 6, 7, 8].map((number) => `series-${String(number)}`);

test("the file has the four blocks that this test reads", () => {
  expect(blocks()).toHaveLength(4);
});

test("the dark theme is the same whether the machine or the person asks for it", () => {
  expect(autoDark).toEqual(dark);
});

describe.each(Object.entries(themes))("theme %s", (_name, tokens) => {
  const token = (name: string): string => {
    const colour = tokens?.[`--t-${name}`];
    if (colour === undefined) throw new Error(`no colour --t-${name}`);
    return colour;
  };

  test.each(texts.flatMap((text) => backgrounds.map((background) => [text, background] as const)))(
    "%s on %s has a contrast of 4.5 at least",
    (text, background) => {
      expect(contrast(token(text), token(background))).toBeGreaterThanOrEqual(4.5);
    },
  );

  test.each([
    ["on-accent", "accent"],
    ["on-bad", "bad"],
  ])("%s on %s has a contrast of 4.5 at least", (text, background) => {
    expect(contrast(token(text), token(background))).toBeGreaterThanOrEqual(4.5);
  });

  test.each([...series, "edge"])("the line %s stands out from its surface by 3 at least", (line) => {
    expect(contrast(token(line), token("surface"))).toBeGreaterThanOrEqual(3);
  });
});

test("the night theme has hardly any green and blue, so that eyes stay adapted", () => {
  const glaring = Object.entries(night ?? {}).filter(([, colour]) => {
    const [r = 0, , b = 0] = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
    return b > 140 || b > r;
  });
  expect(glaring).toEqual([]);
});

test("words of boxes on a camera's picture have a contrast of 4.5 at least, on black", () => {
  const boxes = [...css.matchAll(/--t-box-[a-z]+:\s*(#[0-9a-f]{6})/g)].map((match) => match[1] ?? "");
  expect(boxes).toHaveLength(8);
  expect(boxes.filter((colour) => contrast(colour, "#000000") < 4.5)).toEqual([]);
});
