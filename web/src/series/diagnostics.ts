/** The robot's diagnostics as a tree: the newest status of each name, and how each part stands. Pure. */

import { msg } from "@lit/localize";
import { fullText, listOf } from "../topics/topic-tree.js";

/** The gravest last, except that silence is less grave than an error. */
export type DiagnosticLevel = "ok" | "warn" | "stale" | "error";

export interface DiagnosticStatus {
  readonly name: string;
  readonly level: DiagnosticLevel;
  readonly message: string;
  readonly hardware: string;
  readonly values: readonly (readonly [key: string, value: string])[];
  /** Since it was heard (ms). */
  readonly ageMs: number;
}

export interface DiagnosticNode {
  /** The last part of its name. */
  readonly name: string;
  /** Parts of its name with slashes between; empty for all of it. */
  readonly path: string;
  /** The gravest of it and of all below it. */
  readonly level: DiagnosticLevel;
  readonly status: DiagnosticStatus | null;
  readonly children: readonly DiagnosticNode[];
  /** How many statuses it and all below it have, by level. */
  readonly counts: Readonly<Record<DiagnosticLevel, number>>;
}

const GRAVITY: Readonly<Record<DiagnosticLevel, number>> = { ok: 0, warn: 1, stale: 2, error: 3 };
/** As `diagnostic_msgs/DiagnosticStatus` has them. */
const LEVELS: readonly DiagnosticLevel[] = ["ok", "warn", "error", "stale"];
/** A status that is not said again for so long is stale (ms), or for three times as long as it took before. */
const STALE_MS = 5000;
const PERIODS = 3;
/** Names that are kept; a robot has some hundreds. The one that was heard longest ago goes. */
const MOST_NAMES = 2000;

interface KeptStatus {
  readonly name: string;
  readonly level: DiagnosticLevel;
  readonly message: string;
  readonly hardware: string;
  readonly values: readonly (readonly [string, string])[];
  readonly heardMs: number;
  readonly periodMs: number;
}

interface OpenNode {
  readonly name: string;
  readonly path: string;
  status: DiagnosticStatus | null;
  readonly children: Map<string, OpenNode>;
}

export class DiagnosticsBook {
  private readonly kept = new Map<string, KeptStatus>();
  /** Statuses that had no room in the messages so far. */
  private missing = 0;

  get size(): number {
    return this.kept.size;
  }

  /** How many statuses of the newest messages were left out, because there were too many. */
  get leftOut(): number {
    return this.missing;
  }

  clear(): void {
    this.kept.clear();
    this.missing = 0;
  }

  /** Takes a `DiagnosticArray`; several nodes publish on one topic, so nothing that it lacks is forgotten. */
  addMessage(message: unknown, nowMs: number): void {
    const { entries, left } = listOf(fieldOf(message, "status"));
    this.missing = left;
    for (const entry of entries) {
      const name = fullText(fieldOf(entry, "name"));
      const before = this.kept.get(name);
      // Newest last, so that the first is the one that was heard longest ago.
      this.kept.delete(name);
      this.kept.set(name, {
        name,
        level: LEVELS[Number(fieldOf(entry, "level"))] ?? "error",
        message: fullText(fieldOf(entry, "message")),
        hardware: fullText(fieldOf(entry, "hardware_id")),
        values: listOf(fieldOf(entry, "values")).entries.map((pair) => [fullText(fieldOf(pair, "key")), fullText(fieldOf(pair, "value"))] as const),
        heardMs: nowMs,
        periodMs: before === undefined ? 0 : nowMs - before.heardMs,
      });
    }
    for (const name of this.kept.keys()) {
      if (this.kept.size <= MOST_NAMES) break;
      this.kept.delete(name);
    }
  }

  /** All of it as it stands at a moment. */
  treeAt(nowMs: number): DiagnosticNode {
    const root: OpenNode = { name: "", path: "", status: null, children: new Map() };
    for (const kept of this.kept.values()) {
      const node = diagnosticParts(kept.name).reduce(childOf, root);
      node.status = statusAt(kept, nowMs);
    }
    return closeNode(root);
  }
}

/** The parts of a status' name: of aggregated ones between slashes, else the node and what is behind it. */
export function diagnosticParts(name: string): readonly string[] {
  const parts = name.split("/").map((part) => part.trim()).filter((part) => part !== "");
  if (parts.length > 1 || name.trimStart().startsWith("/")) return parts.length === 0 ? [name] : parts;
  const at = name.indexOf(": ");
  return at <= 0 ? [name.trim() === "" ? msg("(no name)") : name.trim()] : [name.slice(0, at).trim(), name.slice(at + 2).trim()].filter((part) => part !== "");
}

/** Whether a node, or anything below it, is called so, or says so. */
export function nodeMatches(node: DiagnosticNode, words: string): boolean {
  const { status } = node;
  const text = `${node.path} ${status?.name ?? ""} ${status?.message ?? ""} ${status?.hardware ?? ""}`.toLowerCase();
  return text.includes(words.toLowerCase()) || node.children.some((child) => nodeMatches(child, words));
}

function childOf(node: OpenNode, name: string): OpenNode {
  let child = node.children.get(name);
  if (child === undefined) {
    child = { name, path: node.path === "" ? name : `${node.path}/${name}`, status: null, children: new Map() };
    node.children.set(name, child);
  }
  return child;
}

function statusAt({ heardMs, periodMs, ...said }: KeptStatus, nowMs: number): DiagnosticStatus {
  const ageMs = Math.max(0, nowMs - heardMs);
  const silent = ageMs > Math.max(STALE_MS, PERIODS * periodMs);
  return { ...said, level: silent ? "stale" : said.level, ageMs };
}

function closeNode(open: OpenNode): DiagnosticNode {
  const children = [...open.children.values()].map(closeNode).sort((a, b) => a.name.localeCompare(b.name, "en", { numeric: true }));
  const counts: Record<DiagnosticLevel, number> = { ok: 0, warn: 0, stale: 0, error: 0 };
  if (open.status !== null) counts[open.status.level] += 1;
  for (const child of children) for (const level of LEVELS) counts[level] += child.counts[level];
  const own = open.status?.level ?? "ok";
  const level = children.reduce<DiagnosticLevel>((worst, child) => (GRAVITY[child.level] > GRAVITY[worst] ? child.level : worst), own);
  return { name: open.name, path: open.path, status: open.status, level, children, counts };
}

function fieldOf(value: unknown, name: string): unknown {
  return typeof value === "object" && value !== null ? (value as Readonly<Record<string, unknown>>)[name] : undefined;
}
