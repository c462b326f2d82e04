/** What the pages of missions and of the fleet are made of, in each of their states. */

import { html, type TemplateResult } from "lit";
import type { GroupCommandClient, GroupCommandRow } from "../../controllers/drive/group-command-client.js";
import type { GroupStopClient, GroupStopRow } from "../../controllers/drive/group-stop-client.js";
import type { MissionRunShape, SharedCommandShape, SiteSummary } from "../../generated/api.js";
import { Store } from "../../state/store.js";
import { emptyDraft, emptyStep } from "../missions/mission-draft.js";
import type { GalleryEntry } from "./entry.js";
import "../fleet/fleet-chooser.js";
import "../fleet/fleet-command.js";
import "../fleet/fleet-stop.js";
import "../missions/mission-form.js";
import "../missions/mission-run.js";

const NOON_US = 1_780_000_000_000_000;

function siteRow(site: string, name: string, more: Partial<SiteSummary> = {}): SiteSummary {
  return {
    site, name, zone: "UTC", online: true, since_us: NOON_US, last_seen_us: NOON_US, why: "", loop_ms: 4, skew_ms: 0, rival_us: 0, devices: 3, signals: 12, stale: 0,
    group: "", tags: [], state: "", battery: null, latitude: null, longitude: null, moving: false, heading: null, driver: "", stream: "", stops: ["base"], ...more,
  };
}

const FLEET = [
  siteRow("anna", "Anna", { group: "Warehouse north", tags: ["indoor", "forklift"], state: "docked" }),
  siteRow("bruno", "Bruno", { group: "Warehouse north", state: "on its way" }),
  siteRow("clara", "Clara", { online: false }),
  siteRow("roof", "Observatory", { stops: [] }),
] as const;

const WANDER: SharedCommandShape = {
  device: "base",
  device_name: "Vehicle base",
  command: { id: "wander", name: "Wander about", role: "none", description: "It drives about by itself.", confirm: false, timeout: 60, cancellable: true, arguments: [], needs: null, ros: "" },
  sites: ["anna", "bruno", "clara"],
  barred: [],
};

/** Stands in for the client that sends: its rows are what happened. */
function stopped(...rows: readonly GroupStopRow[]): GroupStopClient {
  return Object.assign(new Store(), { rows }) as unknown as GroupStopClient;
}

function asked(...rows: readonly GroupCommandRow[]): GroupCommandClient {
  return Object.assign(new Store(), { rows }) as unknown as GroupCommandClient;
}

function stopRow(site: string, phase: GroupStopRow["phase"], more: Partial<GroupStopRow> = {}): GroupStopRow {
  return { site, device: "base", phase, online: true, waitingMs: 0, answerMs: 38, who: "Marta", ...more };
}

function commandRow(site: string, phase: GroupCommandRow["phase"], message: string, progress = 0): GroupCommandRow {
  return { site, device: "base", command: "wander", id: `group-1.${site}`, phase, message, progress, since: 0, blockedBy: "" };
}

function run(state: string, why: string, ...steps: readonly (readonly [string, string])[]): MissionRunShape {
  return {
    id: "1", mission: "1", name: "Morning round", who: "Marta", begun_by: "schedule", state, why, began_us: NOON_US, ended_us: 0,
    steps: steps.map(([how, message], at) => ({ name: ["Vehicle base: Go to (1.5 m, 0 m)", "wait 10 s", "Vehicle base: Dock"][at] ?? "", state: how, message, began_us: NOON_US, ended_us: how === "running" || how === "waiting" ? 0 : NOON_US + 4.2e6 })),
  };
}

function renderRun(shown: MissionRunShape): TemplateResult {
  return html`<t-mission-run .run=${shown} allowed></t-mission-run>`;
}

function renderStop(...rows: readonly GroupStopRow[]): TemplateResult {
  return html`<t-fleet-stop .rows=${FLEET} .line=${stopped(...rows)}></t-fleet-stop>`;
}

function renderCommand(chosen: readonly SiteSummary[], ...rows: readonly GroupCommandRow[]): TemplateResult {
  return html`<t-fleet-command .chosen=${chosen} .commands=${[WANDER]} .line=${asked(...rows)}></t-fleet-command>`;
}

export const entries: readonly GalleryEntry[] = [
  {
    tag: "t-mission-run",
    wide: true,
    states: [
      { name: "running", show: () => renderRun(run("running", "", ["succeeded", "arrived"], ["running", ""], ["waiting", ""])) },
      { name: "paused", show: () => renderRun(run("paused", "", ["succeeded", "arrived"], ["waiting", ""], ["waiting", ""])) },
      { name: "ended by STOP", show: () => renderRun(run("stopped", "STOP is latched at Vehicle base, pressed by Marta", ["cancelled", ""], ["waiting", ""], ["waiting", ""])) },
      { name: "interrupted: nobody knows how the step ended", show: () => renderRun(run("interrupted", "the link to the gateway was lost", ["unknown", ""], ["waiting", ""], ["waiting", ""])) },
      { name: "missed", show: () => renderRun(run("missed", "the site was away")) },
    ],
  },
  {
    tag: "t-mission-form",
    wide: true,
    states: [
      { name: "new", show: () => html`<t-mission-form></t-mission-form>` },
      { name: "with waits and a schedule", show: () => html`<t-mission-form .draft=${{ ...emptyDraft(), name: "Morning round", schedule: "weekly" as const, days: ["mon", "fri"], steps: [{ ...emptyStep("until"), condition: "{base/battery} > 40" }, emptyStep("pause")] }}></t-mission-form>` },
    ],
  },
  {
    tag: "t-fleet-stop",
    wide: true,
    states: [
      { name: "not pressed", show: () => renderStop() },
      { name: "pressed, at four robots in four states", show: () => renderStop(stopRow("anna", "confirmed"), stopRow("bruno", "latched"), stopRow("clara", "sent", { online: false, answerMs: null, who: "" }), stopRow("roof", "sent", { waitingMs: 1800, answerMs: null, who: "" })) },
      { name: "none has STOP", show: () => html`<t-fleet-stop .rows=${FLEET.slice(3)}></t-fleet-stop>` },
    ],
  },
  {
    tag: "t-fleet-chooser",
    wide: true,
    states: [
      { name: "two are chosen", show: () => html`<t-fleet-chooser .rows=${FLEET} .chosen=${new Set(["anna", "bruno"])}></t-fleet-chooser>` },
      { name: "no site", show: () => html`<t-fleet-chooser></t-fleet-chooser>` },
    ],
  },
  {
    tag: "t-fleet-command",
    wide: true,
    states: [
      { name: "nobody is chosen", show: () => renderCommand([]) },
      { name: "none is open to these", show: () => html`<t-fleet-command .chosen=${FLEET.slice(3)}></t-fleet-command>` },
      { name: "sent, with what became of it", show: () => renderCommand(FLEET, commandRow("anna", "succeeded", "wandering"), commandRow("bruno", "running", "", 0.4), commandRow("clara", "refused", "Rain locks it")) },
    ],
  },
];
