/** The dashboard's few icons: 24 by 24, drawn with the text's colour. Decorative: a word stands beside. */

import { svg, type SVGTemplateResult } from "lit";

const PATHS = {
  home: "M4 11 12 4l8 7M6 9.5V20h12V9.5M10 20v-6h4v6",
  live: "M3 13h4l2.5-7 4 12 2.5-7H21",
  history: "M4 5v5h5M4.6 10A8 8 0 1 1 4 14M12 8v4.5l3 2",
  drive: "M12 3v18M3 12h18M12 3 9.5 5.5M12 3l2.5 2.5M12 21l-2.5-2.5M12 21l2.5-2.5M3 12l2.5-2.5M3 12l2.5 2.5M21 12l-2.5-2.5M21 12l-2.5 2.5",
  person: "M12 12a4 4 0 1 0 0-8 4 4 0 0 0 0 8ZM4.5 20.5a7.5 7.5 0 0 1 15 0",
  down: "m7 10 5 5 5-5",
  warn: "M12 4 2.8 20h18.4zM12 10v4.5M12 17v.5",
  info: "M12 21a9 9 0 1 0 0-18 9 9 0 0 0 0 18ZM12 11v5.5M12 7.5V8",
  lock: "M6 11h12v9H6zM8.5 11V8a3.5 3.5 0 0 1 7 0v3",
  copy: "M9 9h11v11H9zM15 9V4H4v11h5",
  boards: "M4 4h7v9H4zM14 4h6v5h-6zM14 12h6v8h-6zM4 16h7v4H4z",
  devices: "M4 5h16v6H4zM4 14h16v6H4zM7.5 8h.5M7.5 17h.5",
  shield: "M12 3.5 19 6v5.5c0 4.4-2.9 7.6-7 9-4.1-1.4-7-4.6-7-9V6zM9 11.8l2.2 2.2 4-4.2",
  open: "M3 12s3.3-6 9-6 9 6 9 6-3.3 6-9 6-9-6-9-6ZM12 14.6a2.6 2.6 0 1 0 0-5.2 2.6 2.6 0 0 0 0 5.2Z",
  people: "M9 11.5a3.5 3.5 0 1 0 0-7 3.5 3.5 0 0 0 0 7ZM2.5 19.5a6.5 6.5 0 0 1 13 0M16 11a3 3 0 1 0-1-5.8M17.5 14a6 6 0 0 1 4 5.5",
  bell: "M6 16.5V11a6 6 0 0 1 12 0v5.5l1.5 2h-15zM10 20.5a2 2 0 0 0 4 0",
  logbook: "M6 3.5h12v17H6zM9 8h6M9 12h6M9 16h4",
  close: "M6 6l12 12M18 6 6 18",
  moon: "M20 14.5A8.5 8.5 0 0 1 9.5 4a8.5 8.5 0 1 0 10.5 10.5Z",
  camera: "M4 7.5h4L9.5 5h5L16 7.5h4V19H4zM12 16.5a3.5 3.5 0 1 0 0-7 3.5 3.5 0 0 0 0 7Z",
  unlinked: "M9 15l-2 2a3.5 3.5 0 0 1-5-5l3-3a3.5 3.5 0 0 1 4 0M15 9l2-2a3.5 3.5 0 0 1 5 5l-3 3a3.5 3.5 0 0 1-4 0M5 5l14 14",
} as const;

export type IconName = keyof typeof PATHS;

/** The inside of an `<svg viewBox="0 0 24 24">`. */
export function renderIconPath(name: IconName): SVGTemplateResult {
  return svg`<path d=${PATHS[name]} fill="none" stroke="currentColor" stroke-width="1.75"
    stroke-linecap="round" stroke-linejoin="round"></path>`;
}
