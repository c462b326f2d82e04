/** Charts and what stands around them, with samples that do not change. */

import { html, type TemplateResult } from "lit";
import { indentOf, type ChartAxis, type ChartSeries } from "../../elements/chart/chart-model.js";
import { Trace } from "../../series/trace.js";
import { outliersOf } from "../../series/outliers.js";
import type { TimeSpan } from "../../series/time-window.js";
import { ChartFeed, type HistorySource, type SampleSource } from "../../tiles/chart/chart-feed.js";
import type { DeviceShape, SignalShape, StatisticsShape } from "../../generated/api.js";
import { loadedSeries, type LoadedSeries } from "../history/data/history-loader.js";
import type { EventMark, MarkKind } from "../history/chart/event-marks.js";
import type { HistoryView } from "../history/history-query.js";
import type { ChannelRow, ChartGroup } from "../history/data/channel-rows.js";
import type { GalleryEntry } from "./entry.js";
import "../../elements/chart/chart.js";
import "../../tiles/chart/chart-tile.js";
import "../history/export-menu.js";
import "../history/chart/history-chart.js";
import "../history/history-tools.js";
import "../history/chart/marks-lane.js";
import "../history/share-menu.js";
import "../history/signal-picker.js";
import "../history/view-options.js";

const END_US = 1_780_000_000_000_000;
const LENGTH_US = 30e6;
const STEP_US = 50_000;
const SPAN: TimeSpan = { fromUs: END_US - LENGTH_US, toUs: END_US };
const AXIS: ChartAxis = { limits: { minimum: null, maximum: null }, least: 0 };
const ZONE = "Europe/Madrid";

function wave(seconds: number, phase = 0): number {
  const spike = Math.abs(seconds - 12) < 0.03 ? 0.5 : 0;
  return 0.1 * Math.sin(seconds / 2 + phase) + 0.02 * Math.sin(seconds * 31) + spike;
}

function fill(trace: Trace, valueAt: (seconds: number) => number, step = STEP_US): Trace {
  for (let us = SPAN.fromUs; us < END_US; us += step) trace.addSample(us, valueAt((us - SPAN.fromUs) / 1e6));
  return trace;
}

function samples(valueAt: (seconds: number) => number): Trace {
  return fill(new Trace(Infinity, 5e6), valueAt);
}

/** A thousand samples a second: many to a pixel. */
function dense(level: number): Trace {
  return fill(new Trace(Infinity, 5e6), (s) => wave(s, level) + level + 0.04 * Math.sin(s * 977), STEP_US / 50);
}

function series(change: Partial<ChartSeries> = {}): ChartSeries {
  return {
    address: "base/speed",
    name: "Speed",
    unit: "m/s",
    decimals: -1,
    colour: 0,
    samples: samples(wave),
    states: [],
    gaps: [],
    stale: false,
    ...change,
  };
}

function renderChart(list: readonly ChartSeries[], span: TimeSpan = SPAN): TemplateResult {
  return html`<t-chart .series=${list} .span=${span} .axis=${AXIS} zone=${ZONE} label="A chart" zoomable></t-chart>`;
}

function holed(seconds: number): number {
  return seconds > 14 && seconds < 20 ? NaN : wave(seconds);
}

const GAP = { from_us: SPAN.fromUs + 14e6, to_us: SPAN.fromUs + 20e6, reason: "the spool was full" };
const STATES = ["off", "on", "fault"];

function signal(change: Partial<SignalShape> = {}): SignalShape {
  const plain: SignalShape = {
    id: "speed",
    address: "base/speed",
    name: "Speed",
    type: "number",
    role: "none",
    unit: "m/s",
    decimals: -1,
    minimum: -0.25,
    maximum: 0.25,
    shown: null,
    states: [],
    meanings: [],
    frame: "local",
    max_age: 5,
    primary: true,
    public: false,
    ros: "",
    channels: ["base/speed"],
  };
  return { ...plain, ...change };
}

const NOBODY: SampleSource = { subscribe: () => () => undefined };
const NO_PAST: HistorySource = { history: () => Promise.resolve({ series: [] }) };

/** A feed that has heard all its samples this long ago (s). */
function feed(what: SignalShape, ageS: number, valueAt: (seconds: number) => number, text: string | null = null): ChartFeed {
  const made = new ChartFeed("gallery", NOBODY, NO_PAST, () => undefined, LENGTH_US);
  made.subscribeSignals([what]);
  made.edge.observe(END_US, performance.now(), ageS * 1000);
  for (const address of what.channels) {
    const channel = made.channelOf(address);
    fill(channel.trace, valueAt);
    channel.text = text;
    channel.timeUs = END_US;
    channel.freshAtMs = performance.now() - ageS * 1000;
  }
  return made;
}

function renderTile(what: SignalShape, made: ChartFeed, paused = false, forbidden = false): TemplateResult {
  return html`<t-chart-tile .feed=${made} .signal=${what} .paused=${paused} .forbidden=${forbidden} zone=${ZONE}></t-chart-tile>`;
}

// Fresh for a day, so that the gallery can be looked at for long.
const LASTING = signal({ max_age: 86_400 });
const SILENT = new ChartFeed("gallery", NOBODY, NO_PAST, () => undefined, LENGTH_US);
const WANDER = signal({ name: "Wander mode", type: "state", states: STATES, max_age: 86_400 });
const PLACE = signal({ name: "Position", type: "position", channels: ["base/pose.x", "base/pose.y", "base/pose.yaw"], max_age: 86_400 });
const WORDS = signal({ name: "Last message", type: "text", max_age: 86_400 });

const DEVICE: DeviceShape = { id: "base", name: "Vehicle base", kind: "vehicle", signals: [], streams: [], commands: [], drive: null, public: false, link_loss: "", pointing: null, slew: null, unguarded: false, rights: [] };
const ROWS: readonly ChannelRow[] = [
  { address: "base/speed", device: DEVICE, name: "Speed", type: "number", unit: "m/s", decimals: -1, shown: null, states: [], maxAge: 5, primary: true, former: false },
  { address: "base/other", device: DEVICE, name: "Other speed", type: "number", unit: "m/s", decimals: -1, shown: null, states: [], maxAge: 5, primary: true, former: false },
];
const GROUP: ChartGroup = { key: "m/s", title: "m/s", type: "number", rows: ROWS };

const TEXT_ROW: ChannelRow = {
  address: "base/said", device: DEVICE, name: "Last message", type: "text", unit: "", decimals: -1, shown: null, states: [], maxAge: 60, primary: true, former: false,
};
const TEXT_GROUP: ChartGroup = { key: "said", title: "Last message", type: "text", rows: [TEXT_ROW] };
const NUMBERS: ReadonlyMap<string, StatisticsShape> = new Map(
  ROWS.map(({ address }, i) => {
    const reading = (v: number): { t_us: number; v: number } => ({ t_us: SPAN.fromUs, v: v + i * 0.3 });
    const statistics = { address, count: 480, numbers: 480, low: reading(-0.12), high: reading(0.62), mean: i * 0.3, deviation: 0.07 };
    return [address, { ...statistics, first: null, last: null, gap_us: 6e6 }];
  }),
);
const UNITS: readonly ChartSeries[] = [
  series(),
  series({ address: "v", name: "Voltage", unit: "V", colour: 1, samples: samples((s) => 12 - s / 100) }),
  series({ address: "t", name: "Temperature", unit: "°C", colour: 2, samples: samples((s) => 21 + Math.cos(s / 6)) }),
];
const MARKS: readonly EventMark[] = [
  { timeUs: SPAN.fromUs + 4e6, kind: "driving", title: "lease taken", device: "Vehicle base", who: "ada", message: "", good: true },
  { timeUs: SPAN.fromUs + 9e6, kind: "command", title: "command asked", device: "Vehicle base", who: "ada", message: "wander(active=True)", good: true },
  { timeUs: SPAN.fromUs + 9.2e6, kind: "command", title: "command failed", device: "Vehicle base", who: "ada", message: "no answer", good: false },
  { timeUs: SPAN.fromUs + 17e6, kind: "stop", title: "stop pressed", device: "Vehicle base", who: "ada", message: "", good: true },
  { timeUs: SPAN.fromUs + 21e6, kind: "alarm", title: "alarm raised", device: "Battery", who: "", message: "below 11.7 V", good: false },
  { timeUs: SPAN.fromUs + 26e6, kind: "link", title: "gateway lost", device: "", who: "", message: "", good: false },
];

function renderLane(without: readonly MarkKind[], more = false): TemplateResult {
  return html`<t-marks-lane .marks=${MARKS} .without=${without} .span=${SPAN} .indent=${indentOf(1, 60)} ?more=${more} zone=${ZONE}></t-marks-lane>`;
}

function renderOptions(change: Partial<HistoryView>): TemplateResult {
  const view: HistoryView = { channels: null, shown: SPAN, joined: false, without: [], versus: 0, shiftUs: 0, outliers: 0, ...change };
  return html`<t-view-options .view=${view} .span=${SPAN} zone=${ZONE}></t-view-options>`;
}

function texts(): ReadonlyMap<string, LoadedSeries> {
  const said = ["Docked at the charger in the kitchen", "On the way to the hall", "Waiting"];
  const t_us = said.map((_, i) => SPAN.fromUs + i * 9e6);
  return new Map([["base/said", loadedSeries({ address: "base/said", t_us, v: [null, null, null], text: said, kind: "exact", gaps: [] }, 60e6)]]);
}

/** @param above added to each value */
function past(above = 0): ReadonlyMap<string, LoadedSeries> {
  const times = Array.from({ length: 600 }, (_, i) => SPAN.fromUs + i * STEP_US);
  return new Map(
    ROWS.map(({ address }, i) => {
      const v = times.map((us) => holed((us - SPAN.fromUs) / 1e6) + i * 0.3 + above).map((value) => (Number.isNaN(value) ? null : value));
      return [address, loadedSeries({ address, t_us: times, v, kind: "exact", gaps: [GAP] }, 5e6)];
    }),
  );
}

function renderHistoryChart(data: ReadonlyMap<string, LoadedSeries>, cursorUs: number | null): TemplateResult {
  return html`<t-history-chart
    .group=${GROUP}
    .data=${data}
    .numbers=${NUMBERS}
    .span=${SPAN}
    .cursorUs=${cursorUs}
    .newest=${new Map([["base/speed", SPAN.fromUs - 3600e6]])}
    loaded
    zone=${ZONE}
  ></t-history-chart>`;
}

export const entries: readonly GalleryEntry[] = [
  {
    tag: "t-chart",
    wide: true,
    states: [
      { name: "line, with a spike that is kept", show: () => renderChart([series()]) },
      {
        name: "several, with the band from least to greatest",
        show: () => renderChart([series({ samples: dense(0) }), series({ address: "b", name: "Other", colour: 1, samples: dense(0.4) })]),
      },
      { name: "gap with its reason", show: () => renderChart([series({ samples: samples(holed), gaps: [GAP] })]) },
      { name: "stale", show: () => renderChart([series({ stale: true })]) },
      { name: "states", show: () => renderChart([series({ states: STATES, samples: samples((s) => Math.floor(s / 7) % 3) })]) },
      {
        name: "an axis for each unit",
        show: () =>
          html`<t-chart .series=${UNITS} .span=${SPAN} .axis=${AXIS} .indent=${indentOf(3, 48)} many-axes zone=${ZONE} label="Three units"></t-chart>`,
      },
      { name: "another time behind", show: () => renderChart([series({ ghost: { samples: samples((s) => wave(s, 1)), shiftUs: 0 } })]) },
      {
        name: "marks of what happened",
        show: () => html`<t-chart .series=${[series()]} .span=${SPAN} .axis=${AXIS} .marks=${MARKS} zone=${ZONE} label="Marks"></t-chart>`,
      },
      {
        name: "outliers",
        show: () => html`<t-chart .series=${[series()]} .span=${SPAN} .axis=${AXIS} .outliers=${new Map([["base/speed", outliersOf(series().samples.times, series().samples.values, SPAN, 1.5)]])} zone=${ZONE} label="Outliers"></t-chart>`,
      },
      { name: "empty", show: () => renderChart([series({ samples: new Trace(Infinity, 5e6) })]) },
    ],
  },
  {
    tag: "t-chart-tile",
    wide: true,
    states: [
      { name: "number, live", show: () => renderTile(LASTING, feed(LASTING, 0, wave)) },
      { name: "number, paused", show: () => renderTile(LASTING, feed(LASTING, 0, wave), true) },
      { name: "number, stale", show: () => renderTile(signal(), feed(signal(), 9, wave)) },
      {
        name: "a link on the way is down",
        show: () => html`<t-chart-tile .feed=${feed(LASTING, 1, wave)} .signal=${LASTING} cut zone=${ZONE}></t-chart-tile>`,
      },
      { name: "no data yet", show: () => renderTile(signal(), SILENT) },
      { name: "forbidden", show: () => renderTile(signal(), SILENT, false, true) },
      { name: "state", show: () => renderTile(WANDER, feed(WANDER, 0, (s) => Math.floor(s / 7) % 2)) },
      { name: "position", show: () => renderTile(PLACE, feed(PLACE, 0, (s) => s / 10)) },
      { name: "text", show: () => renderTile(WORDS, feed(WORDS, 0, () => NaN, "Docked at the charger in the kitchen")) },
    ],
  },
  {
    tag: "t-history-chart",
    wide: true,
    states: [
      { name: "two of a unit", show: () => renderHistoryChart(past(), null) },
      { name: "cursor from another chart", show: () => renderHistoryChart(past(), SPAN.fromUs + 8e6) },
      {
        name: "outliers",
        show: () => html`<t-history-chart .group=${GROUP} .data=${past()} .numbers=${NUMBERS} .span=${SPAN} .outliers=${0.5} loaded zone=${ZONE}></t-history-chart>`,
      },
      { name: "no samples", show: () => renderHistoryChart(new Map(), null) },
      {
        name: "another day behind",
        show: () =>
          html`<t-history-chart .group=${GROUP} .data=${past()} .ghost=${past(-0.1)} .ghostUs=${LENGTH_US / 8} ghost-name="27 May" .numbers=${NUMBERS} .span=${SPAN} loaded zone=${ZONE}></t-history-chart>`,
      },
      {
        name: "texts",
        show: () => html`<t-history-chart .group=${TEXT_GROUP} .data=${texts()} .span=${SPAN} loaded zone=${ZONE}></t-history-chart>`,
      },
    ],
  },
  {
    tag: "t-marks-lane",
    wide: true,
    states: [
      { name: "several kinds, two of them close together", show: () => renderLane([]) },
      { name: "driving hidden, older ones left out", show: () => renderLane(["driving"], true) },
      { name: "nothing happened", show: () => html`<t-marks-lane .span=${SPAN} .indent=${indentOf(1, 60)}></t-marks-lane>` },
    ],
  },
  {
    tag: "t-view-options",
    wide: true,
    states: [
      { name: "plain", show: () => renderOptions({}) },
      { name: "units in one chart, a week before", show: () => renderOptions({ joined: true, versus: 7, outliers: 0 }) },
      { name: "another day", show: () => renderOptions({ versus: 12, outliers: 0 }) },
    ],
  },
  {
    tag: "t-share-menu",
    states: [{ name: "of a window that follows", show: () => html`<t-share-menu fixed="https://hub/a" live="https://hub/b"></t-share-menu>` }],
  },
  {
    tag: "t-export-menu",
    states: [{ name: "one signal", show: () => html`<t-export-menu site="agv" .channels=${["base/speed"]} .span=${SPAN}></t-export-menu>` }],
  },
  {
    tag: "t-history-tools",
    wide: true,
    states: [
      { name: "following", show: () => html`<t-history-tools .shown=${{ last: 900 }} .span=${SPAN} zone=${ZONE}></t-history-tools>` },
      { name: "a window that stands still", show: () => html`<t-history-tools .shown=${SPAN} .span=${SPAN} zone=${ZONE}></t-history-tools>` },
    ],
  },
  {
    tag: "t-signal-picker",
    states: [{ name: "one of two chosen", show: () => html`<t-signal-picker .rows=${ROWS} .chosen=${["base/speed"]}></t-signal-picker>` }],
  },
];
