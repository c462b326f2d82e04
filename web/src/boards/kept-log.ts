/** Kept lines of a robot's log beside those that come live: each once, the newest first. Pure. */

import { msg } from "@lit/localize";
import type { LogLineShape, LogPageShape } from "../generated/api.js";
import { levelWord, type RobotLogLine } from "./robot-log.js";

/** Lines of a page that is asked for. */
export const LOG_PAGE = 200;

export interface LogQuestion {
  readonly level: number;
  /** Part of the node's name. */
  readonly node: string;
  readonly words: string;
  /** Up to this moment (µs); null: up to now. */
  readonly toUs: number | null;
  /** Behind this place; null: from the newest on. */
  readonly before: string | null;
}

export interface ShownLogLine {
  readonly key: string;
  readonly timeUs: number;
  readonly level: number;
  /** What stands for the level. */
  readonly word: string;
  readonly node: string;
  readonly text: string;
  /** File and line of the source; empty: unknown. */
  readonly source: string;
}

/** What the hub is asked for. A part of a node's name is a word that it looks for in names, too. */
export function logQuery({ level, node, words, toUs, before }: LogQuestion): string {
  const query = new URLSearchParams({ level: String(level), text: `${node} ${words}`.trim().slice(0, 200), limit: String(LOG_PAGE) });
  if (toUs !== null) query.set("to_us", String(Math.floor(toUs)));
  if (before !== null) query.set("before", before);
  return query.toString();
}

export class KeptLog {
  private lines: readonly LogLineShape[] = [];
  /** Where older ones are; null: there are none. */
  next: string | null = null;

  get size(): number {
    return this.lines.length;
  }

  clear(): void {
    this.lines = [];
    this.next = null;
  }

  /** Takes the newest lines; of so many new ones that some may lie between, the old ones go. */
  addNewest({ lines, next }: LogPageShape): void {
    const known = new Set(this.lines.map(({ id }) => id));
    const fresh = lines.filter(({ id }) => !known.has(id));
    if (this.lines.length === 0 || (fresh.length === lines.length && next !== null)) {
      this.lines = lines;
      this.next = next;
      return;
    }
    this.lines = [...fresh, ...this.lines].sort(newestFirst);
  }

  addOlder({ lines, next }: LogPageShape): void {
    this.lines = [...this.lines, ...lines];
    this.next = next;
  }

  /** Those of nodes with `node` in their names, with the live ones that are not among them. */
  shownWith(live: readonly RobotLogLine[], node: string): readonly ShownLogLine[] {
    const part = node.toLowerCase();
    const kept = this.lines.filter((line) => line.left_out > 0 || line.node.toLowerCase().includes(part));
    const known = new Set(kept.map(({ time_us, node: name }) => `${String(time_us)} ${name}`));
    const fresh = live.filter((line) => !known.has(`${String(Math.floor(line.timeUs))} ${line.node}`));
    const shown = [
      ...kept.map(shownLine),
      ...fresh.map(({ number, timeUs, level, node: name, message }) => ({ key: `live ${String(number)}`, timeUs, level, word: levelWord(level), node: name, text: message, source: "" })),
    ];
    // The sort is stable: of one moment the hub's order stays.
    return shown.sort((one, other) => other.timeUs - one.timeUs);
  }
}

export function shownLine(line: LogLineShape): ShownLogLine {
  const { id, time_us: timeUs, level, node, text, file } = line;
  const source = file === "" ? "" : `${file}:${String(line.line)}`;
  return { key: id, timeUs, level, word: line.left_out > 0 ? msg("Left out") : levelWord(level), node, text, source };
}

function newestFirst(one: LogLineShape, other: LogLineShape): number {
  return other.time_us - one.time_us || Number(other.id) - Number(one.id);
}
