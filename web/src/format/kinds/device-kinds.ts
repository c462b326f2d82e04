/** Kinds of devices in the page's language. Pure. */

import { msg } from "@lit/localize";

const KINDS: Readonly<Record<string, string>> = {
  vehicle: msg("vehicle"),
  dome: msg("dome"),
  telescope: msg("telescope"),
  camera: msg("camera", { id: "camera.kind" }),
  weather: msg("weather station"),
  power: msg("power supply"),
  other: msg("other device"),
};

/** What kind of device it is, as people read it. */
export function deviceKindWords(kind: string): string {
  return KINDS[kind] ?? kind;
}
