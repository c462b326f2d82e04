/** Anomaly detectors in each of their states, with scores that do not change. */

import { html, type TemplateResult } from "lit";
import { anomalyMarks } from "../../elements/chart/anomaly-marks.js";
import { indentOf, type ChartSeries } from "../../elements/chart/chart-model.js";
import { Trace } from "../../series/trace.js";
import type { TimeSpan } from "../../series/time-window.js";
import type { Detector } from "../../state/anomaly-detectors.js";
import type { AnomalyList, AnomalyShape, HistoryAnswer } from "../../generated/api.js";
import { Refused, Unreachable } from "../../wire/hub-api.js";
import type { ScoreSource } from "../history/chart/anomaly-scores.js";
import type { GalleryEntry } from "./entry.js";
import "../../elements/analysis/detector.js";
import "../history/chart/anomaly-scores.js";

const END_US = 1_780_000_000_000_000;
const SPAN: TimeSpan = { fromUs: END_US - 600e6, toUs: END_US };
const BEGAN_US = END_US - 150e6;
const ENDED_US = END_US - 90e6;
const ZONE = "Europe/Madrid";
const WHY = "11.2 V is 0.61 V below the 11.81 V of the last 12 min, a change greater than nearly all before";

function scoreAt(us: number): number {
  const quiet = 0.25 + 0.12 * Math.sin(us / 31e6) + 0.05 * Math.sin(us / 2.3e6);
  return us >= BEGAN_US && us <= ENDED_US ? 0.82 : quiet;
}

const TIMES = Array.from({ length: 600 }, (_, i) => SPAN.fromUs + i * 1e6);

function info(change: Partial<AnomalyShape> = {}): AnomalyShape {
  const plain: AnomalyShape = {
    address: "power/voltage", detector: "together", name: "all together", bar: 0.65, score: 0.31, scores: "power/voltage~together",
    began_us: -1, from_us: 0, to_us: 0, why: "", forgiven: false,
    confirmed: false, learns: true, learning: 0, late: 0,
    title: "", signals: [], step_s: 0, mode: "", shares: [],
  };
  return { ...plain, ...change };
}

const USUAL = info();
const ON = info({ began_us: BEGAN_US, from_us: BEGAN_US, score: 0.82, why: WHY });
const OVER = info({ from_us: BEGAN_US, to_us: ENDED_US, why: WHY });
const MARKED = info({ from_us: BEGAN_US, to_us: ENDED_US, why: WHY, forgiven: true });

function past(): Promise<HistoryAnswer> {
  const v = TIMES.map(scoreAt);
  return Promise.resolve({ series: [{ address: "power/voltage~together", t_us: TIMES, v, kind: "exact", gaps: [] }] });
}

/** A hub that answers this way and no other. */
function hub(anomalies: () => Promise<AnomalyList>, forgive: () => Promise<boolean> = () => Promise.resolve(true)): ScoreSource {
  return { anomalies, history: past, dismissAnomaly: forgive };
}

function listed(detector: AnomalyShape, may_forgive = true): () => Promise<AnomalyList> {
  return () => Promise.resolve({ detectors: [detector], may_forgive, skipped: 0 });
}

function never<T>(): Promise<T> {
  return new Promise<T>(() => undefined);
}

function renderAnomalies(answers: ScoreSource, channels: readonly string[] = ["power/voltage"]): TemplateResult {
  return html`<t-anomalies site="gallery" .hub=${answers} .channels=${channels} .span=${SPAN} width="800" zone=${ZONE}></t-anomalies>`;
}

function trace(): Trace {
  const made = new Trace(Infinity, 130e6);
  for (const us of TIMES) made.addSample(us, scoreAt(us));
  return made;
}

const SERIES: ChartSeries = {
  address: "power/voltage~together", name: "Score", unit: "", decimals: 2, colour: 1, samples: trace(), states: [], gaps: [], stale: false,
};

function renderDetector(change: Partial<Detector>, mayForgive = true): TemplateResult {
  const detector: Detector = {
    address: "power/voltage", detector: "together", name: "all together", bar: 0.65, score: 0.31, scores: "power/voltage~together",
    learns: true, learning: 0, on: false, anomaly: null, title: "", signals: [], stepS: 0, mode: "", ...change,
  };
  const marks = detector.anomaly === null ? [] : anomalyMarks([detector.anomaly]);
  return html`<t-detector
    .detector=${detector}
    .score=${detector.score}
    .series=${SERIES}
    .marks=${marks}
    .span=${SPAN}
    .indent=${indentOf(1, 48)}
    ?may-forgive=${mayForgive}
    zone=${ZONE}
  ></t-detector>`;
}

const ANOMALY = { scores: "power/voltage~together", fromUs: BEGAN_US, toUs: ENDED_US, why: WHY, title: "", shares: [], forgiven: false };
const SHARES = [
  { signal: "power/voltage", share: 0.62, spreads: -5.3 },
  { signal: "power/current", share: 0.31, spreads: 2.1 },
  { signal: "base/speed", share: 0.07, spreads: -0.4 },
];
const GROUP: Partial<Detector> = {
  address: "/power", detector: "group", name: "signals together", title: "Battery", bar: 0.5, scores: "/power~group",
  signals: ["power/voltage", "power/current", "base/speed"], stepS: 1, mode: "driving",
};
const GROUP_ANOMALY = { ...ANOMALY, scores: "/power~group", title: "Battery", shares: SHARES, why: "together 3 signals are 2.4 times as far from their usual state as ever while it learned: Voltage (62%, 5.3 spreads below its level), Current (31%, 2.1 spreads above its level)" };

export const entries: readonly GalleryEntry[] = [
  {
    tag: "t-anomalies",
    wide: true,
    states: [
      { name: "loading", show: () => renderAnomalies(hub(never)) },
      { name: "empty: none watches these signals", show: () => renderAnomalies(hub(listed(USUAL)), ["base/speed"]) },
      { name: "error", show: () => renderAnomalies(hub(() => Promise.reject(new Unreachable("The hub does not answer.")))) },
      { name: "forbidden", show: () => renderAnomalies(hub(() => Promise.reject(new Refused(403, "forbidden", "you may not")))) },
      { name: "as usual", show: () => renderAnomalies(hub(listed(USUAL))) },
      { name: "on", show: () => renderAnomalies(hub(listed(ON))) },
      { name: "ended", show: () => renderAnomalies(hub(listed(OVER))) },
      { name: "ended, for somebody who may only look", show: () => renderAnomalies(hub(listed(OVER, false))) },
      { name: "marked: not an anomaly", show: () => renderAnomalies(hub(listed(MARKED))) },
      { name: "the mark is refused (press it)", show: () => renderAnomalies(hub(listed(ON), () => Promise.reject(new Refused(403, "forbidden", "you do not have the right to do this")))) },
    ],
  },
  {
    tag: "t-detector",
    wide: true,
    states: [
      { name: "learning", show: () => renderDetector({ learning: 620 }) },
      { name: "as usual", show: () => renderDetector({}) },
      { name: "on", show: () => renderDetector({ on: true, anomaly: { ...ANOMALY, toUs: Infinity } }) },
      { name: "ended", show: () => renderDetector({ anomaly: ANOMALY }) },
      { name: "ended, for somebody who may only look", show: () => renderDetector({ anomaly: ANOMALY }, false) },
      { name: "marked", show: () => renderDetector({ anomaly: { ...ANOMALY, forgiven: true } }) },
      { name: "a group that learns", show: () => renderDetector({ ...GROUP, learning: 1200 }) },
      { name: "a group, on, with its shares", show: () => renderDetector({ ...GROUP, on: true, anomaly: { ...GROUP_ANOMALY, toUs: Infinity } }) },
      { name: "limits, which learn nothing", show: () => renderDetector({ name: "limits", learns: false, on: true, anomaly: { ...ANOMALY, toUs: Infinity, why: "11.2 V is below the least of 11.5 V" } }) },
    ],
  },
];
