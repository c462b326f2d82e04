/** Lines of a unified difference, told apart for eyes and for screen readers. */

import { msg, str } from "@lit/localize";
import { plural } from "../words/plural.js";

export type LineKind = "added" | "removed" | "same" | "place";

export interface DifferenceLine {
  readonly kind: LineKind;
  /** Stands before it, so that colour is not all that tells it apart. */
  readonly sign: string;
  readonly text: string;
  /** Its number before and after; 0 where it is not in that text. */
  readonly before: number;
  readonly after: number;
}

const PLACE = /^@@ -(\d+)(?:,\d+)? \+(\d+)(?:,\d+)? @@/;

/** @param lines as of a unified difference: with `@@`, and `+`, `-` or a blank before each other line */
export function differenceLines(lines: readonly string[]): DifferenceLine[] {
  let before = 0;
  let after = 0;
  return lines.map((line) => {
    const place = PLACE.exec(line);
    if (place !== null) {
      before = Number(place[1]);
      after = Number(place[2]);
      return { kind: "place", sign: "…", text: msg(str`line ${String(after)}`), before: 0, after: 0 };
    }
    const text = line.slice(1);
    if (line.startsWith("+")) return { kind: "added", sign: "+", text, before: 0, after: after++ };
    if (line.startsWith("-")) return { kind: "removed", sign: "−", text, before: before++, after: 0 };
    return { kind: "same", sign: " ", text, before: before++, after: after++ };
  });
}

/** How many lines came and went, in words. */
export function differenceText(lines: readonly DifferenceLine[]): string {
  const added = lines.filter((line) => line.kind === "added").length;
  const removed = lines.filter((line) => line.kind === "removed").length;
  if (added + removed === 0) return msg("no line differs");
  const said = [added > 0 ? msg(str`${lineCount(added)} added`) : "", removed > 0 ? msg(str`${lineCount(removed)} removed`) : ""];
  return said.filter((address) => address !== "").join(", ");
}

function lineCount(count: number): string {
  return plural(count, msg("1 line"), msg(str`${String(count)} lines`));
}
