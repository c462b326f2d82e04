/** Numbers of a raw topic's messages over time, of fields that somebody chose. Pure. */

/** One message's number, and when it came (`performance.now`). */
export interface FieldPoint {
  readonly atMs: number;
  readonly value: number;
}

export interface FieldTrace {
  /** As descriptions write it: `twist.linear.x`, `shelves[1].celsius`. */
  readonly path: string;
  readonly points: readonly FieldPoint[];
}

/** As many as have a colour of their own. */
export const MOST_FIELDS = 4;
/** What is kept (ms). */
export const KEPT_MS = 60_000;

/** The number at a path; 0 and 1 of what is true or not, null of anything else. */
export function numberAt(tree: unknown, path: string): number | null {
  let value = tree;
  for (const part of path.split(/[.[\]]+/).filter(Boolean)) {
    if (typeof value !== "object" || value === null) return null;
    // A long array is told by its first entries.
    const inside: unknown = "$first" in value ? value.$first : value;
    value = (inside as Readonly<Record<string, unknown>>)[part];
  }
  if (typeof value === "boolean") return Number(value);
  return typeof value === "number" && Number.isFinite(value) ? value : null;
}

export class FieldTraces {
  private kept: ReadonlyMap<string, readonly FieldPoint[]> = new Map();

  get paths(): readonly string[] {
    return [...this.kept.keys()];
  }

  get traces(): readonly FieldTrace[] {
    return [...this.kept].map(([path, points]) => ({ path, points }));
  }

  /** These and no others; what stays keeps what it has. */
  choose(paths: readonly string[]): void {
    this.kept = new Map([...new Set(paths)].slice(0, MOST_FIELDS).map((path) => [path, this.kept.get(path) ?? []]));
  }

  /** One more or one less; of too many the oldest goes. */
  toggle(path: string): void {
    const { paths } = this;
    this.choose(paths.includes(path) ? paths.filter((other) => other !== path) : [...paths, path].slice(-MOST_FIELDS));
  }

  /** What was kept is of another topic. */
  clear(): void {
    this.kept = new Map(this.paths.map((path) => [path, []]));
  }

  addMessage(tree: unknown, atMs: number): void {
    this.kept = new Map(
      [...this.kept].map(([path, points]) => {
        const value = numberAt(tree, path);
        const recent = points.filter((point) => atMs - point.atMs <= KEPT_MS);
        return [path, value === null ? recent : [...recent, { atMs, value }]];
      }),
    );
  }
}
