/** How the anomaly detectors of a site stand: the hub's list, and what was told since. */

import type { AnomalyUpdate } from "../generated/wire.js";
import type { AnomalyList, AnomalyShape } from "../generated/api.js";

/** One detector of a signal. */
export interface Detector {
  /** Of the signal. */
  readonly address: string;
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
  /** A person said that it was none. */
  readonly forgiven: boolean;
}

/** Of each detector so many anomalies are remembered. */
const MOST = 50;

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

  /** The anomalies of a signal that this page knows of, in order of time. */
  anomalies(address: string): readonly Anomaly[] {
    const all = this.detectorsOf(address).flatMap(({ scores }) => this.past.get(scores) ?? []);
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
    const { on, score, learning } = news;
    const now: Detector = { ...before, on, score, learning, anomaly: anomalyOf(before.scores, news) };
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
  const { address, detector, name, bar, score, scores, learns, learning, began_us } = anomaly;
  const on = began_us >= 0;
  return { address, detector, name, bar, score, scores, learns, learning, on, anomaly: anomalyOf(scores, { ...anomaly, on }) };
}

function anomalyOf(scores: string, said: Pick<AnomalyUpdate, "from_us" | "to_us" | "why" | "forgiven" | "on">): Anomaly | null {
  const { from_us, to_us, why, forgiven, on } = said;
  return from_us === 0 ? null : { scores, fromUs: from_us, toUs: on ? Infinity : to_us, why, forgiven };
}
