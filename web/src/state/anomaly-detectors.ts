/** How the anomaly detectors of a site stand: the hub's list, and what was told since. */

import type { AnomalyUpdate } from "../generated/wire.js";
import type { AnomalyList, AnomalyShape, ShareShape } from "../generated/api.js";

/** One detector of a signal, or of a group of signals. */
export interface Detector {
  /** Of the signal; of a group it begins with a slash. */
  readonly address: string;
  /** What people call a group; empty for a signal. */
  readonly title: string;
  /** The signals of a group. */
  readonly signals: readonly string[];
  /** A group looks at them so often (s); 0 for a signal. */
  readonly stepS: number;
  /** The way of running that a group is in; empty where it has one. */
  readonly mode: string;
  /** Its word in the site description. */
  readonly detector: string;
  readonly name: string;
  /** A score from here on is an anomaly. */
  readonly bar: number;
  readonly score: number;
  /** The channel of its scores. */
  readonly scores: string;
  /** A person can tell it what is usual. */
  readonly learns: boolean;
  /** So many samples until it has learned; 0 once it has. */
  readonly learning: number;
  /** An anomaly is on. */
  readonly on: boolean;
  readonly anomaly: Anomaly | null;
}

/** One anomaly; µs since the epoch, UTC. */
export interface Anomaly {
  /** The channel of the scores of the detector that tells it. */
  readonly scores: string;
  readonly fromUs: number;
  /** Infinity while it is on. */
  readonly toUs: number;
  readonly why: string;
  /** What people call the group that it is of; empty for a signal. */
  readonly title: string;
  /** Which signals of a group made it so, the greatest share first. */
  readonly shares: readonly ShareShape[];
  /** A person said that it was none. */
  readonly forgiven: boolean;
}

/** Of each detector so many anomalies are remembered. */
const MOST = 50;
/** A signal with a smaller share of a group's anomaly has nothing to do with it. */
const LEAST_SHARE = 0.1;

/**
 * Puts the list and the news together: what was told while the list was on its way is newer than it.
 */
export class AnomalyDetectors {
  mayForgive = false;
  private known: ReadonlyMap<string, Detector> = new Map();
  private listed: readonly Detector[] = [];
  private readonly since = new Map<string, AnomalyUpdate>();
  private readonly past = new Map<string, readonly Anomaly[]>();

  /** All of them; another array whenever one stands otherwise. */
  get list(): readonly Detector[] {
    return this.listed;
  }

  detectorsOf(address: string): readonly Detector[] {
    return this.list.filter((detector) => detector.address === address);
  }

  /** The anomalies of a signal that this page knows of, in order of time; of groups those that it had a part in. */
  anomalies(address: string): readonly Anomaly[] {
    const all = this.list.flatMap((detector) => {
      const past = this.past.get(detector.scores) ?? [];
      if (detector.address === address) return past;
      return detector.signals.includes(address) ? past.filter((anomaly) => shareOf(anomaly, address) >= LEAST_SHARE) : [];
    });
    return all.sort((a, b) => a.fromUs - b.fromUs);
  }

  /** The list is being asked for: what is told from now on is newer. */
  beginLoad(): void {
    this.since.clear();
  }

  setList(list: AnomalyList): void {
    this.mayForgive = list.may_forgive;
    this.setDetectors(new Map(list.detectors.map((detector) => [detector.scores, detectorOf(detector)])));
    for (const detector of this.known.values()) this.recordAnomaly(detector);
    for (const news of this.since.values()) this.replaceDetector(news);
  }

  /** Takes news; gives whether it is about a detector that is known. */
  applyUpdate(news: AnomalyUpdate): boolean {
    this.since.set(scoresOf(news), news);
    return this.replaceDetector(news);
  }

  private replaceDetector(news: AnomalyUpdate): boolean {
    const before = this.known.get(scoresOf(news));
    if (before === undefined) return false;
    const { on, score, learning, mode } = news;
    const shares = news.shares.map(({ signal, share, spreads }) => ({ signal, share, spreads }));
    const now: Detector = { ...before, on, score, learning, mode, anomaly: anomalyOf(before.scores, before.title, { ...news, shares }) };
    this.setDetectors(new Map(this.known).set(before.scores, now));
    this.recordAnomaly(now);
    return true;
  }

  private setDetectors(known: ReadonlyMap<string, Detector>): void {
    this.known = known;
    this.listed = [...known.values()];
  }

  private recordAnomaly({ scores, anomaly }: Detector): void {
    if (anomaly === null) return;
    const others = (this.past.get(scores) ?? []).filter(({ fromUs }) => fromUs !== anomaly.fromUs);
    this.past.set(scores, [...others, anomaly].slice(-MOST));
  }
}

function scoresOf({ address, detector }: AnomalyUpdate): string {
  return `${address}~${detector}`;
}

function detectorOf(anomaly: AnomalyShape): Detector {
  const { address, detector, name, bar, score, scores, learns, learning, began_us, title, signals, step_s, mode } = anomaly;
  const on = began_us >= 0;
  const plain = { address, detector, name, bar, score, scores, learns, learning, on, title, signals, stepS: step_s, mode };
  return { ...plain, anomaly: anomalyOf(scores, title, { ...anomaly, on }) };
}

type Said = Pick<AnomalyShape, "from_us" | "to_us" | "why" | "forgiven" | "shares"> & { readonly on: boolean };

function anomalyOf(scores: string, title: string, { from_us, to_us, why, forgiven, on, shares }: Said): Anomaly | null {
  return from_us === 0 ? null : { scores, fromUs: from_us, toUs: on ? Infinity : to_us, why, title, shares, forgiven };
}

/** The share (0 to 1) that a signal had in a group's anomaly. */
export function shareOf({ shares }: Anomaly, address: string): number {
  return shares.find(({ signal }) => signal === address)?.share ?? 0;
}

/** What people call what a detector looks at. */
export function subjectOf({ title, address }: Detector): string {
  return title === "" ? address : title;
}
