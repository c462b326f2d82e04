/** Sizes of files and disks. */

import { fixedText } from "./number.js";

const NAMES = ["B", "kB", "MB", "GB", "TB", "PB"] as const;
const STEP = 1000;

/** Three digits at most, in powers of a thousand as disks are sold: `4.31 GB`, `812 kB`. */
export function formatBytes(bytes: number): string {
  if (!Number.isFinite(bytes)) return "–";
  let size = Math.max(0, bytes);
  let name = 0;
  // What rounds to a thousand is one of the next.
  while (size >= STEP - 0.5 && name < NAMES.length - 1) {
    size /= STEP;
    name += 1;
  }
  const digits = name === 0 || size >= 99.95 ? 0 : size >= 9.995 ? 1 : 2;
  return `${fixedText(size, digits)}\u202f${NAMES[name] ?? ""}`;
}
