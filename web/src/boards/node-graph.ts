/** Nodes and topics of a robot as a drawing: who publishes what to whom, in columns from left to right. Pure. */

import type { GraphNodeShape } from "../generated/api.js";

export type GraphKind = "node" | "topic";

/** A box; its key tells a node from a topic of the same name. */
export interface GraphBox {
  readonly key: string;
  readonly name: string;
  readonly kind: GraphKind;
  readonly column: number;
  /** From the top of its column. */
  readonly row: number;
}

export interface GraphLine {
  readonly from: string;
  readonly to: string;
}

export interface GraphDrawing {
  readonly boxes: readonly GraphBox[];
  readonly lines: readonly GraphLine[];
  readonly columns: number;
  /** Of the column that has most. */
  readonly rows: number;
  /** Boxes that there are and that have no room. */
  readonly left: number;
}

/** More boxes nobody tells apart. */
export const MOST_BOXES = 60;
/** What every node of ROS has, and what says nothing of how the robot works. */
const PLUMBING: readonly string[] = ["/rosout", "/rosout_agg", "/parameter_events", "/clock", "/diagnostics"];
const SWEEPS = 6;

export function keyOf(kind: GraphKind, name: string): string {
  return `${kind} ${name}`;
}

export function isPlumbing(topic: string): boolean {
  return PLUMBING.includes(topic);
}

/** All names, nodes first, in which every word stands. */
export function searchGraph(nodes: readonly GraphNodeShape[], words: string): readonly { readonly key: string; readonly kind: GraphKind; readonly name: string }[] {
  const wanted = words.toLowerCase().split(/\s+/).filter(Boolean);
  const topics = new Set(nodes.flatMap(({ publishes, subscribes }) => [...publishes, ...subscribes]));
  const all = [
    ...nodes.map(({ name }) => ({ key: keyOf("node", name), kind: "node" as const, name })),
    ...[...topics].sort().map((name) => ({ key: keyOf("topic", name), kind: "topic" as const, name })),
  ];
  return all.filter(({ name }) => wanted.every((word) => name.toLowerCase().includes(word)));
}

/**
 * @param focus the box around which is drawn, two steps far; empty: all
 * @param plumbing what every node has, too
 */
export function drawGraph(nodes: readonly GraphNodeShape[], focus: string, plumbing: boolean): GraphDrawing {
  const lines = linesOf(nodes, plumbing || (focus.startsWith("topic ") && isPlumbing(focus.slice("topic ".length))));
  const keys = focus === "" ? joinedKeys(nodes, lines) : around(focus, lines);
  const shown = new Set(keys.slice(0, MOST_BOXES));
  const kept = lines.filter(({ from, to }) => shown.has(from) && shown.has(to));
  const column = columnsOf([...shown], kept, focus);
  const places = rowsOf(column, kept);
  const boxes = [...shown].map((key): GraphBox => {
    const kind = key.startsWith("node ") ? "node" : "topic";
    return { key, name: key.slice(kind.length + 1), kind, column: column.get(key) ?? 0, row: places.get(key) ?? 0 };
  });
  return {
    boxes, lines: kept, left: keys.length - shown.size,
    columns: Math.max(0, ...boxes.map((box) => box.column + 1)),
    rows: Math.max(0, ...boxes.map((box) => box.row + 1)),
  };
}

function linesOf(nodes: readonly GraphNodeShape[], plumbing: boolean): readonly GraphLine[] {
  return nodes.flatMap(({ name, publishes, subscribes }) => {
    const of = (topics: readonly string[]): readonly string[] => topics.filter((topic) => plumbing || !isPlumbing(topic));
    return [
      ...of(publishes).map((topic) => ({ from: keyOf("node", name), to: keyOf("topic", topic) })),
      ...of(subscribes).map((topic) => ({ from: keyOf("topic", topic), to: keyOf("node", name) })),
    ];
  });
}

/** What is joined to most stands first, so that of too many the least is left out. */
function joinedKeys(nodes: readonly GraphNodeShape[], lines: readonly GraphLine[]): readonly string[] {
  const counts = new Map(nodes.map(({ name }) => [keyOf("node", name), 0]));
  for (const key of lines.flatMap(({ from, to }) => [from, to])) counts.set(key, (counts.get(key) ?? 0) + 1);
  return [...counts].sort(([a, many], [b, more]) => more - many || a.localeCompare(b)).map(([key]) => key);
}

/** A topic with its nodes; a node with its topics, and whom it hears and who hears it by them. */
function around(focus: string, lines: readonly GraphLine[]): readonly string[] {
  const found = new Set([focus]);
  const spread = (begin: readonly string[], next: (key: string) => readonly string[]): void => {
    for (const first of begin) {
      found.add(first);
      if (focus.startsWith("node ")) for (const second of next(first)) found.add(second);
    }
  };
  const after = (key: string): readonly string[] => lines.filter(({ from }) => from === key).map(({ to }) => to);
  const before = (key: string): readonly string[] => lines.filter(({ to }) => to === key).map(({ from }) => from);
  spread(after(focus), after);
  spread(before(focus), before);
  return [...found];
}

/** As few steps as it takes from where a way begins; around a focus so many steps before or behind it. */
function columnsOf(keys: readonly string[], lines: readonly GraphLine[], focus: string): Map<string, number> {
  const after = new Map<string, string[]>(keys.map((key) => [key, []]));
  const before = new Map<string, string[]>(keys.map((key) => [key, []]));
  for (const { from, to } of lines) {
    after.get(from)?.push(to);
    before.get(to)?.push(from);
  }
  const column = new Map<string, number>();
  const spread = (begin: readonly string[], ways: ReadonlyMap<string, readonly string[]>, by: 1 | -1): void => {
    for (const key of begin) if (!column.has(key)) column.set(key, 0);
    const open = [...begin];
    for (let key = open.shift(); key !== undefined; key = open.shift()) {
      for (const next of ways.get(key) ?? []) {
        if (column.has(next)) continue;
        column.set(next, (column.get(key) ?? 0) + by);
        open.push(next);
      }
    }
  };
  if (focus !== "" && after.has(focus)) {
    spread([focus], after, 1);
    spread([focus], before, -1);
  }
  // Those that hear nobody begin; of circles whoever says most.
  spread(keys.filter((key) => before.get(key)?.length === 0), after, 1);
  const rest = [...keys].sort((a, b) => (after.get(b)?.length ?? 0) - (after.get(a)?.length ?? 0) || a.localeCompare(b));
  for (const key of rest) if (!column.has(key)) spread([key], after, 1);
  const least = Math.min(0, ...column.values());
  return new Map([...column].map(([key, at]) => [key, at - least]));
}

/** In each column near to what it is joined to, so that few lines cross. */
function rowsOf(column: ReadonlyMap<string, number>, lines: readonly GraphLine[]): Map<string, number> {
  const columns: string[][] = [];
  for (const [key, at] of [...column].sort(([a], [b]) => a.localeCompare(b))) (columns[at] ??= []).push(key);
  const rows = new Map<string, number>();
  const number = (keys: readonly string[]): void => {
    keys.forEach((key, row) => rows.set(key, row));
  };
  columns.forEach(number);
  const joined = new Map<string, string[]>();
  for (const { from, to } of lines) {
    joined.set(from, [...(joined.get(from) ?? []), to]);
    joined.set(to, [...(joined.get(to) ?? []), from]);
  }
  for (let sweep = 0; sweep < SWEEPS; sweep += 1) {
    const ways = sweep % 2 === 0 ? columns : [...columns].reverse();
    for (const keys of ways) {
      const middle = new Map(keys.map((key) => {
        const others = (joined.get(key) ?? []).map((other) => rows.get(other) ?? 0);
        return [key, others.length === 0 ? (rows.get(key) ?? 0) : others.reduce((sum, row) => sum + row, 0) / others.length];
      }));
      keys.sort((a, b) => (middle.get(a) ?? 0) - (middle.get(b) ?? 0));
      number(keys);
    }
  }
  return rows;
}
