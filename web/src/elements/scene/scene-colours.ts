/** A scene's colours by the theme's tokens, which are `#rrggbb`. */

import type { SceneColours } from "./drawing.js";

export function sceneColours(element: Element): SceneColours {
  const style = getComputedStyle(element);
  const token = (name: string): string => style.getPropertyValue(`--t-${name}`).trim();
  return {
    background: token("bg"),
    line: token("line"),
    strong: token("edge"),
    text: token("text"),
    accent: token("accent"),
    scan: token("series-2"),
    path: token("series-1"),
    poses: token("series-4"),
    floor: token("surface"),
    wall: token("muted"),
    unknown: token("line"),
    night: document.documentElement.dataset["theme"] === "night",
  };
}
