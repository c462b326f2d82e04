/** What a night by itself is drawn with. */

import { html } from "lit";
import { proposalMarks, type BlockPause, type NightBlock } from "../../series/plan-layout.js";
import { nightSky } from "../../sky/night-sky.js";
import type { SkyFieldShape } from "../../generated/api.js";
import { mosaicOf } from "../../sky/mosaic.js";
import type { GalleryEntry } from "./entry.js";
import "../../elements/observatory/framing-view.js";
import "../../elements/observatory/plan-timeline.js";
import "../../elements/observatory/sky-chart.js";

const MONTSEC = { latitude: 42.0517, longitude: 0.7297 };
const HOUR = 3_600_000;
const EVENING = Date.parse("2026-11-23T16:30:00Z");
const SPAN = { from: EVENING, to: EVENING + 15 * HOUR };
const NOW = EVENING + 5.2 * HOUR;
const SKY = nightSky(MONTSEC, SPAN);

function pausesFrom(startMs: number, turns: boolean): readonly BlockPause[] {
  const focus: BlockPause = { kind: "focus", startMs: startMs - 120_000, endMs: startMs, reason: "another filter: R" };
  const flip: BlockPause = { kind: "flip", startMs: startMs + HOUR / 2, endMs: startMs + HOUR / 2 + 98_000, reason: "its target passes the meridian" };
  return turns ? [focus, flip] : [focus];
}

const BLOCKS: readonly NightBlock[] = (
  [
    ["NGC 7000", "school-1", 1.6, 2.5, "done", "highest of those allowed"],
    ["M 31", "survey", 2.55, 3.4, "suspended", "clouds over 60 %"],
    ["T CrB", "variables", 3.45, 3.6, "failed", "guide star lost"],
    ["M 31", "survey", 4.6, 5.6, "current", "goes on with 12 of 30 frames"],
    ["M 42", "school-1", 5.7, 7.2, "planned", "best at 03:10"],
    ["M 1", "survey", 7.25, 8.9, "planned", "its window ends at 02:30"],
    ["RZ Cas", "variables", 8.95, 9.2, "planned", "phase 0.98 to 0.02"],
    ["M 51", "school-1", 11, 13.2, "planned", "rises above 30° at 04:20"],
  ] as const
).map(([name, proposal, start, end, state, reason], i) => ({
  id: String(i), request: String(i), name, proposal, state, reason, startMs: EVENING + start * HOUR, endMs: EVENING + end * HOUR,
  pauses: state === "planned" ? pausesFrom(EVENING + start * HOUR, name === "M 42") : [],
}));
const MARKS = proposalMarks(BLOCKS.map(({ proposal }) => proposal));

const GALAXY = { raDeg: 10.6848, decDeg: 41.2691 };
const SKY_OF_M31: SkyFieldShape = {
  available: true,
  stars: [[12.45, 41.08, 4.5], [9.22, 41.25, 7.1], [10.1, 41.9, 7.6], [11.6, 40.6, 6.9], [9.7, 40.5, 8], [11.1, 42.2, 8.3], [10.4, 40.8, 7.9]].map(
    ([ra = 0, dec = 0, magnitude = 0]) => ({ ra_deg: ra, dec_deg: dec, magnitude }),
  ),
  objects: [
    { name: "NGC0224", also: ["M031"], kind: "Galaxy", ra_deg: 10.6848, dec_deg: 41.2691, major: 2.96, minor: 1.16, angle: 35 },
    { name: "NGC0205", also: ["M110"], kind: "Galaxy", ra_deg: 10.0921, dec_deg: 41.6854, major: 0.27, minor: 0.17, angle: 165 },
  ],
};
const FIELD = { width: 0.8, height: 0.55 };
const MOSAIC = mosaicOf(GALAXY, FIELD, { across: 2, down: 3, overlap: 0.15, angle: 35, rotates: true });

export const entries: readonly GalleryEntry[] = [
  {
    tag: "t-plan-timeline",
    wide: true,
    states: [
      {
        name: "a night under way",
        show: () => html`<t-plan-timeline .span=${SPAN} .sky=${SKY} .blocks=${BLOCKS} .marks=${MARKS} .ms=${NOW} zone="Europe/Madrid" chosen="4"></t-plan-timeline>`,
      },
      { name: "no block yet", show: () => html`<t-plan-timeline .span=${SPAN} .sky=${SKY} .ms=${NOW} zone="Europe/Madrid"></t-plan-timeline>` },
      { name: "place not known", show: () => html`<t-plan-timeline .span=${SPAN} .blocks=${BLOCKS} .marks=${MARKS} .ms=${NOW}></t-plan-timeline>` },
    ],
  },
  {
    tag: "t-sky-chart",
    states: [
      {
        name: "with what is planned",
        show: () => html`<t-sky-chart
          .place=${MONTSEC}
          .ms=${NOW}
          .telescope=${{ name: "Telescope", alt: 62, az: 140 }}
          .limit=${20}
          .planned=${[
            { name: "M 31", letter: "B", colour: 2, alt: 75, az: 200 },
            { name: "M 42", letter: "A", colour: 1, alt: 24, az: 120 },
          ]}
        ></t-sky-chart>`,
      },
    ],
  },
  {
    tag: "t-framing-view",
    states: [
      {
        name: "a mosaic",
        show: () => html`<t-framing-view .anchor=${GALAXY} .span=${4.5} .sky=${SKY_OF_M31} .field=${FIELD} .centre=${GALAXY} .panels=${MOSAIC.panels} name="M 31"></t-framing-view>`,
      },
      {
        name: "one of several fields",
        show: () => html`<t-framing-view
          .anchor=${GALAXY}
          .span=${3}
          .sky=${SKY_OF_M31}
          .field=${FIELD}
          .centre=${GALAXY}
          .panels=${[{ row: 1, column: 1, centre: GALAXY, angle: 0 }]}
          .others=${[{ centre: { raDeg: 10.1, decDeg: 41.7 }, angle: 0 }]}
          name="M 31"
        ></t-framing-view>`,
      },
      {
        name: "stars not loaded",
        show: () => html`<t-framing-view .anchor=${GALAXY} .span=${3} .field=${FIELD} .centre=${GALAXY} .panels=${[{ row: 1, column: 1, centre: GALAXY, angle: 0 }]}></t-framing-view>`,
      },
    ],
  },
];
