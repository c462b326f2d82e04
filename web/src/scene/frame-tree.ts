/** The tree of frames (REP-105) with its past: where a frame stood in another at a time. Pure. */

import { between, composed, IDENTITY, inverted, type Transform } from "./transform.js";

/** Who says where a frame stands; what is named first is believed first. */
export type FrameSource = "tf" | "joints" | "odometry";

const ORDER: readonly FrameSource[] = ["tf", "joints", "odometry"];
/** So long what was is kept (µs): scans are older than the transforms that came meanwhile. */
const KEEP_US = 10e6;
const MOST_KEPT = 1000;
/** So many that are older are taken out together. */
const MANY = 50;
/** A tree is never so deep; a circle would be. */
const MOST_DEPTH = 100;

interface Sample {
  readonly timeUs: number;
  readonly transform: Transform;
}

interface FrameEntry {
  parent: string;
  source: FrameSource;
  fixed: boolean;
  /** By time, the oldest first; of a fixed one the newest alone. */
  samples: Sample[];
  heardMs: number;
}

/** How a frame stands in its parent. */
export interface FrameNews {
  readonly parent: string;
  readonly child: string;
  /** When it was so (µs); of a fixed one it does not matter. */
  readonly timeUs: number;
  readonly transform: Transform;
  readonly source: FrameSource;
  /** Said once, and true until something else is said. */
  readonly fixed: boolean;
}

/** One frame as a list shows it. */
export interface FrameRow {
  readonly name: string;
  readonly parent: string;
  readonly depth: number;
  readonly fixed: boolean;
  readonly source: FrameSource | "";
  /** Since it was last said (s); null of a frame that is nobody's child. */
  readonly age: number | null;
}

/** Names of ROS 1 may begin with a slash, which means nothing. */
export function frameName(name: string): string {
  return name.startsWith("/") ? name.replace(/^\/+/, "") : name;
}

export class FrameTree {
  private readonly frames = new Map<string, FrameEntry>();
  private readonly parents = new Set<string>();
  private changes = 0;

  /** Counts the times that other frames were there, or stood in others: what is made of their names is of use until then. */
  get version(): number {
    return this.changes;
  }

  /** All frames, in no order. */
  names(): readonly string[] {
    return [...new Set([...this.frames.keys(), ...this.parents])];
  }

  clear(): void {
    this.frames.clear();
    this.parents.clear();
    this.changes += 1;
  }

  /** Whether there is such a frame. */
  has(name: string): boolean {
    return this.frames.has(name) || this.parents.has(name);
  }

  /** @param nowMs when it was heard */
  add(news: FrameNews, nowMs: number): void {
    const child = frameName(news.child);
    const parent = frameName(news.parent);
    if (child === "" || parent === "" || child === parent || !isFinite(news.transform)) return;
    const known = this.frames.get(child);
    const stands = known !== undefined && ORDER.indexOf(known.source) < ORDER.indexOf(news.source);
    if (stands) return;
    const moved = known?.parent !== parent;
    // One that stands where it stood closes no circle.
    if (moved && this.wouldCircle(child, parent)) return;
    const sample = { timeUs: news.timeUs, transform: news.transform };
    if (moved) {
      this.parents.add(parent);
      this.changes += 1;
    }
    if (known === undefined || moved || known.source !== news.source || news.fixed || known.fixed) {
      this.frames.set(child, { parent, source: news.source, fixed: news.fixed, samples: [sample], heardMs: nowMs });
      return;
    }
    known.heardMs = nowMs;
    insertSample(known.samples, sample);
  }

  /** Where `frame` stood in `target` at a time; null: nothing joins them. Beyond what is known the nearest that is. */
  find(target: string, frame: string, timeUs: number): Transform | null {
    const [a, b] = [frameName(target), frameName(frame)];
    if (a === b) return IDENTITY;
    // As a rule one is asked for in its parent, or farther up.
    const up = this.toRoot(b, timeUs, a);
    if (up.root === a) return up.transform;
    const other = this.toRoot(a, timeUs);
    if (up.root !== other.root || !this.has(a) || !this.has(b)) return null;
    return composed(inverted(other.transform), up.transform);
  }

  /** Whether a frame is joined to another. */
  isJoined(target: string, frame: string): boolean {
    return this.find(target, frame, 0) !== null;
  }

  /** Frames that are nobody's children. */
  roots(): readonly string[] {
    return [...this.parents].filter((name) => !this.frames.has(name)).sort();
  }

  /** Since a frame was last said (s); null of one that is fixed, or nobody's child. */
  ageOf(name: string, nowMs: number): number | null {
    const entry = this.frames.get(name);
    return entry === undefined || entry.fixed ? null : agedS(entry, nowMs);
  }

  /** All frames, parents before their children. */
  rows(nowMs: number): readonly FrameRow[] {
    const children = new Map<string, string[]>();
    for (const [child, { parent }] of this.frames) children.set(parent, [...(children.get(parent) ?? []), child]);
    const found: FrameRow[] = [];
    const visit = (name: string, depth: number): void => {
      const entry = this.frames.get(name);
      const age = entry === undefined ? null : agedS(entry, nowMs);
      found.push({ name, parent: entry?.parent ?? "", depth, fixed: entry?.fixed ?? false, source: entry?.source ?? "", age });
      for (const child of (children.get(name) ?? []).sort()) visit(child, depth + 1);
    };
    for (const root of this.roots()) visit(root, 0);
    return found;
  }

  /** Up to the root, or to `end` where that is on the way. */
  private toRoot(name: string, timeUs: number, end = ""): { readonly root: string; readonly transform: Transform } {
    let transform = IDENTITY;
    let root = name;
    for (let depth = 0; depth < MOST_DEPTH && root !== end; depth++) {
      const entry = this.frames.get(root);
      if (entry === undefined) break;
      const step = sampleAt(entry.samples, timeUs);
      transform = transform === IDENTITY ? step : composed(step, transform);
      root = entry.parent;
    }
    return { root, transform };
  }

  private wouldCircle(child: string, parent: string): boolean {
    let name: string | undefined = parent;
    for (let depth = 0; name !== undefined; depth++) {
      if (name === child || depth > MOST_DEPTH) return true;
      name = this.frames.get(name)?.parent;
    }
    return false;
  }
}

function agedS({ heardMs }: FrameEntry, nowMs: number): number {
  return Math.max(0, nowMs - heardMs) / 1000;
}

function insertSample(samples: Sample[], sample: Sample): void {
  const last = samples.at(-1);
  // A clock that was set back, or a recording that begins again: what was is not true any more.
  if (last !== undefined && sample.timeUs < last.timeUs - KEEP_US) samples.length = 0;
  let at = samples.length;
  while (at > 0 && (samples[at - 1]?.timeUs ?? 0) > sample.timeUs) at -= 1;
  if (samples[at - 1]?.timeUs === sample.timeUs) samples[at - 1] = sample;
  else samples.splice(at, 0, sample);
  // Many at once: to take the first one out moves all others.
  const oldest = (samples.at(-1)?.timeUs ?? 0) - KEEP_US;
  if (samples.length <= MOST_KEPT && (samples[MANY]?.timeUs ?? Infinity) >= oldest) return;
  const gone = samples.findIndex(({ timeUs }) => timeUs >= oldest);
  samples.splice(0, Math.max(gone, samples.length - MOST_KEPT));
}

function sampleAt(samples: readonly Sample[], timeUs: number): Transform {
  let low = 0;
  let high = samples.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((samples[middle]?.timeUs ?? 0) <= timeUs) low = middle + 1;
    else high = middle;
  }
  const before = samples[low - 1];
  const after = samples[low];
  if (before === undefined || after === undefined) return (before ?? after)?.transform ?? IDENTITY;
  return between(before.transform, after.transform, (timeUs - before.timeUs) / (after.timeUs - before.timeUs));
}

function isFinite({ at, turn }: Transform): boolean {
  // What is not finite makes the sum so, too.
  return Number.isFinite(at[0] + at[1] + at[2] + turn[0] + turn[1] + turn[2] + turn[3]);
}
