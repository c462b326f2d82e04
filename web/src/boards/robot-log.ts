/** Lines of a robot's log (`rcl_interfaces/msg/Log`) as they come: bounded, filtered by level, node and words. Pure. */

import { msg } from "@lit/localize";

/** The levels of ROS 2, the least first. */
export const LOG_LEVELS: readonly (readonly [level: number, word: string])[] = [
  [10, msg("Debug")],
  [20, msg("Info")],
  [30, msg("Warning")],
  [40, msg("Error")],
  [50, msg("Fatal")],
];

export interface RobotLogLine {
  readonly number: number;
  readonly timeUs: number;
  readonly level: number;
  readonly node: string;
  readonly message: string;
}

export interface RobotLogFilter {
  readonly level: number;
  /** Part of the node's name. */
  readonly node: string;
  /** Every word has to be in the line. */
  readonly words: string;
}

const MOST = 2000;

export function levelWord(level: number): string {
  return [...LOG_LEVELS].reverse().find(([least]) => level >= least)?.[1] ?? msg("Debug");
}

export class RobotLog {
  private kept: RobotLogLine[] = [];
  private count = 0;
  /** Older lines are not kept any more. */
  dropped = 0;

  get size(): number {
    return this.kept.length;
  }

  /** @param tree what the hub read of a message; what is no line of a log is left out */
  addMessage(tree: unknown): void {
    if (typeof tree !== "object" || tree === null) return;
    const { level, name, msg, stamp } = tree as Readonly<Record<string, unknown>>;
    if (typeof level !== "number") return;
    const { sec = 0, nanosec = 0 } = (stamp ?? {}) as { sec?: number; nanosec?: number };
    this.kept.push({ number: this.count, timeUs: sec * 1e6 + nanosec / 1000, level, node: plainText(name), message: plainText(msg) });
    this.count += 1;
    if (this.kept.length > MOST) {
      this.dropped += this.kept.length - MOST;
      this.kept = this.kept.slice(-MOST);
    }
  }

  clear(): void {
    this.kept = [];
    this.dropped = 0;
  }

  /** Those that fit, the newest first, `most` of them. */
  linesFor({ level, node, words }: RobotLogFilter, most: number): readonly RobotLogLine[] {
    const wanted = words.toLowerCase().split(/\s+/).filter(Boolean);
    const part = node.toLowerCase();
    const found: RobotLogLine[] = [];
    for (let i = this.kept.length - 1; i >= 0 && found.length < most; i -= 1) {
      const line = this.kept[i];
      if (line === undefined || line.level < level || !line.node.toLowerCase().includes(part)) continue;
      const text = `${line.node} ${line.message}`.toLowerCase();
      if (wanted.every((word) => text.includes(word))) found.push(line);
    }
    return found;
  }
}

/** Of a long text the hub gives the beginning. */
function plainText(value: unknown): string {
  if (typeof value === "string") return value;
  const text = typeof value === "object" && value !== null ? (value as { $text?: unknown }).$text : undefined;
  return typeof text === "string" ? `${text}…` : "";
}
