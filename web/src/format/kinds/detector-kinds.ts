/** What detectors of anomalies are called, in the page's language. Pure. */

import { msg } from "@lit/localize";

/** What the hub calls those that it has itself; one of a package is called as its package says. */
const NAMES: Readonly<Record<string, string>> = {
  "all together": msg("all together"),
  "change of level": msg("change of level"),
  context: msg("context"),
  "flat line": msg("flat line"),
  limits: msg("limits", { id: "limits.detector" }),
  "missing data": msg("missing data"),
  "nearest stretches (KNN-CAD)": msg("nearest stretches"),
  quartiles: msg("quartiles"),
  "rate of change": msg("rate of change"),
  "robust baseline": msg("robust baseline"),
  "time of day": msg("time of day"),
};

/** A detector's name as people read it. */
export function detectorWords(name: string): string {
  return NAMES[name] ?? name;
}
