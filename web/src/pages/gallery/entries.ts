/** The plain elements. Other files named `entries-*.ts` beside this one add theirs. */

import { html } from "lit";
import type { GalleryEntry } from "./entry.js";
import "../../elements/feedback/banner.js";
import "../../elements/forms/button.js";
import "../../elements/layout/card.js";
import "../../elements/forms/choice.js";
import "../../elements/feedback/dialog.js";
import "../../elements/feedback/empty.js";
import "../../elements/forms/field.js";
import "../../elements/base/icon.js";
import "../../elements/feedback/loading.js";
import "../../elements/analysis/outlier-tool.js";
import "../../elements/layout/menu.js";
import "../../elements/feedback/problem.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";
import "../../elements/values/value.js";

const NOON_US = 1_780_000_000_000_000;

function openDialog(event: Event): void {
  if (!(event.currentTarget instanceof HTMLElement)) return;
  const dialog = event.currentTarget.parentElement?.querySelector("t-dialog");
  if (dialog) dialog.open = true;
}

function closeDialog(event: Event): void {
  if (!(event.currentTarget instanceof HTMLElement)) return;
  const dialog = event.currentTarget.closest("t-dialog");
  if (dialog) dialog.open = false;
}

export const entries: readonly GalleryEntry[] = [
  {
    tag: "t-button",
    states: [
      { name: "plain", show: () => html`<t-button>Pause</t-button>` },
      { name: "primary", show: () => html`<t-button kind="primary">Take control</t-button>` },
      { name: "danger", show: () => html`<t-button kind="danger">Delete</t-button>` },
      { name: "quiet", show: () => html`<t-button kind="quiet">Cancel</t-button>` },
      { name: "with icon", show: () => html`<t-button><t-icon name="camera"></t-icon>Picture</t-button>` },
      { name: "pressed", show: () => html`<t-button pressed="true">Grid</t-button>` },
      { name: "disabled", show: () => html`<t-button disabled>Take control</t-button>` },
      { name: "busy", show: () => html`<t-button kind="primary" busy>Signing in…</t-button>` },
    ],
  },
  {
    tag: "t-outlier-tool",
    states: [
      { name: "off", show: () => html`<t-outlier-tool></t-outlier-tool>` },
      { name: "on", show: () => html`<t-outlier-tool .k=${1.5}></t-outlier-tool>` },
    ],
  },
  {
    tag: "t-value",
    states: [
      { name: "live", show: () => html`<t-value .value=${0.1834} unit="m/s"></t-value>` },
      { name: "negative, rounds to zero", show: () => html`<t-value .value=${-0.0004} unit="rad/s"></t-value>` },
      { name: "word", show: () => html`<t-value text="wandering"></t-value>` },
      { name: "stale", show: () => html`<t-value .value=${21.46} unit="°C" state="stale" .age=${72}></t-value>` },
      { name: "unknown", show: () => html`<t-value state="unknown" unit="V"></t-value>` },
      { name: "not reached", show: () => html`<t-value state="unreached" unit="V"></t-value>` },
      { name: "forbidden", show: () => html`<t-value state="forbidden"></t-value>` },
      { name: "no number", show: () => html`<t-value .value=${Number.NaN} unit="m"></t-value>` },
      { name: "large", show: () => html`<t-value size="l" .value=${74.25} unit="%"></t-value>` },
      { name: "across the room", show: () => html`<t-value size="xl" .value=${1013.21} unit="hPa"></t-value>` },
    ],
  },
  {
    tag: "t-status",
    states: [
      { name: "online", show: () => html`<t-status kind="online"></t-status>` },
      { name: "offline", show: () => html`<t-status kind="offline"></t-status>` },
      { name: "stale", show: () => html`<t-status kind="stale"></t-status>` },
      { name: "unknown", show: () => html`<t-status kind="unknown"></t-status>` },
      { name: "ok", show: () => html`<t-status kind="ok"></t-status>` },
      { name: "warn", show: () => html`<t-status kind="warn" word="wind near its limit"></t-status>` },
      { name: "bad", show: () => html`<t-status kind="bad" word="rain"></t-status>` },
      { name: "busy", show: () => html`<t-status kind="busy" word="dome opening"></t-status>` },
    ],
  },
  {
    tag: "t-field",
    states: [
      { name: "empty", show: () => html`<t-field label="Name"><input /></t-field>` },
      { name: "filled, with hint", show: () => html`<t-field label="Speed limit" hint="m/s, up to 0.22"><input .value=${"0.15"} /></t-field>` },
      { name: "wrong", show: () => html`<t-field label="Speed limit" error="It may be 0.22 at the most."><input .value=${"3"} /></t-field>` },
      { name: "disabled", show: () => html`<t-field label="Site"><input disabled .value=${"agv"} /></t-field>` },
      { name: "list", show: () => html`<t-field label="Range"><select><option>Last hour</option><option>Today</option></select></t-field>` },
    ],
  },
  {
    tag: "t-choice",
    states: [
      {
        name: "three",
        show: () => html`<t-choice
          label="Range"
          chosen="hour"
          .options=${[
            { id: "minute", label: "1 min" },
            { id: "hour", label: "1 h" },
            { id: "day", label: "1 d" },
          ]}
        ></t-choice>`,
      },
    ],
  },
  {
    tag: "t-time",
    states: [
      { name: "zone and UTC", show: () => html`<t-time .us=${NOON_US} zone="Europe/Madrid"></t-time>` },
      { name: "short", show: () => html`<t-time short .us=${NOON_US} zone="America/Santiago"></t-time>` },
      { name: "UTC", show: () => html`<t-time .us=${NOON_US}></t-time>` },
      { name: "never", show: () => html`<t-time></t-time>` },
    ],
  },
  {
    tag: "t-menu",
    states: [{ name: "folded", show: () => html`<t-menu><span slot="label">Settings</span><p>What it holds.</p></t-menu>` }],
  },
  {
    tag: "t-dialog",
    states: [
      {
        name: "press to open",
        show: () => html`<t-button @click=${openDialog}>Open it</t-button
          ><t-dialog heading="Open the dome?"
            >The telescope is not parked.<t-button slot="actions" @click=${closeDialog}>Leave it closed</t-button
            ><t-button slot="actions" kind="primary" @click=${closeDialog}>Open the dome</t-button></t-dialog
          >`,
      },
    ],
  },
  {
    tag: "t-banner",
    wide: true,
    states: [
      { name: "info", show: () => html`<t-banner>This is a demo: its accounts are thrown away.</t-banner>` },
      { name: "warn", show: () => html`<t-banner kind="warn">House vehicle is offline. Values are the last known.</t-banner>` },
      { name: "bad", show: () => html`<t-banner kind="bad">No connection to the hub. What you see is old.</t-banner>` },
    ],
  },
  {
    tag: "t-problem",
    wide: true,
    states: [
      { name: "told", show: () => html`<t-problem what="Name or password is wrong." how="Check both; capital letters count."></t-problem>` },
      { name: "with a way on", show: () => html`<t-problem what="The hub cannot be reached." how="Check the network." retry="Try again"></t-problem>` },
    ],
  },
  {
    tag: "t-empty",
    wide: true,
    states: [{ name: "empty", show: () => html`<t-empty heading="No sites yet" icon="unlinked"><p>A site appears once its gateway has connected.</p></t-empty>` }],
  },
  {
    tag: "t-loading",
    states: [{ name: "loading", show: () => html`<t-loading what="Loading your sites"></t-loading>` }],
  },
  {
    tag: "t-card",
    states: [{ name: "with content", show: () => html`<t-card>A sheet that holds what belongs together.</t-card>` }],
  },
];
