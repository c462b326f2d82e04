/** What cockpits are drawn with: numbers over the picture, an arm's joints, a camera's pad. */

import { html, type TemplateResult } from "lit";
import type { HudNumber } from "../../elements/drive/drive-hud.js";
import type { GalleryEntry } from "./entry.js";
import "../../elements/drive/aim-pad.js";
import "../../elements/drive/drive-hud.js";
import "../../elements/drive/joint-bar.js";

const metres = (value: number): HudNumber => ({ value, unit: "m/s", decimals: 2 });
const percent = (value: number): HudNumber => ({ value, unit: "%", decimals: 0 });

function joint(share: number, value: string, near = false): TemplateResult {
  return html`<t-joint name="Shoulder lift" value=${value} low="\u22123.14\u202frad" high="3.14\u202frad" .share=${share} ?near=${near}></t-joint>`;
}

export const entries: readonly GalleryEntry[] = [
  {
    tag: "t-drive-hud",
    states: [
      { name: "driving", show: () => html`<t-drive-hud .speed=${metres(0.12)} .limit=${metres(0.22)} .heading=${78} steers .battery=${percent(87)}></t-drive-hud>` },
      { name: "backwards, in its own frame", show: () => html`<t-drive-hud .speed=${metres(-0.05)} .limit=${metres(0.11)} .heading=${-30} local steers .battery=${percent(62)}></t-drive-hud>` },
      { name: "slowed, battery low", show: () => html`<t-drive-hud .speed=${metres(0.04)} .limit=${metres(0.05)} .heading=${181} steers .battery=${percent(12)} note="Speed capped to 25\u202f%: the link is slow."></t-drive-hud>` },
      { name: "nothing is known now", show: () => html`<t-drive-hud .speed=${metres(Number.NaN)} steers .battery=${percent(Number.NaN)}></t-drive-hud>` },
    ],
  },
  {
    tag: "t-aim-pad",
    states: [
      { name: "pan, tilt and zoom", show: () => html`<t-aim-pad .axes=${["pan", "tilt", "zoom"]}></t-aim-pad>` },
      { name: "zoom alone", show: () => html`<t-aim-pad .axes=${["zoom"]}></t-aim-pad>` },
      { name: "nobody has control", show: () => html`<t-aim-pad .axes=${["pan", "tilt"]} disabled></t-aim-pad>` },
    ],
  },
  {
    tag: "t-joint",
    states: [
      { name: "between its ends", show: () => joint(0.55, "0.31\u202frad") },
      { name: "near an end", show: () => joint(0.98, "3.02\u202frad", true) },
      { name: "not known now", show: () => joint(Number.NaN, "") },
    ],
  },
];
