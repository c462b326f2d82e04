/** Hubs that are one, and releases of gateways, in their states. */

import { html } from "lit";
import type { GatewayReleaseShape, HubShape, ReleaseList, RolloutSiteShape } from "../../generated/api.js";
import type { GalleryEntry } from "./entry.js";
import "../gateways/hub-list.js";
import "../gateways/release-list.js";

function hub(name: string, role: string, change: Partial<HubShape> = {}): HubShape {
  return {
    name, role, version: "0.1.0", own: false, since_us: (Date.now() - 3_700_000) * 1000, cpu: 0.12, memory_bytes: 190e6,
    database_ms: 1.2, gateways: 40, sockets: 12, silent_s: 0, shards: [], ...change,
  };
}

const HUBS = [hub("east", "leads", { own: true, cpu: 0.61, gateways: 120 }), hub("south", "waits", { gateways: 1, sockets: 1 }), hub("west", "waits")];

function gateway(site: string, change: Partial<GatewayReleaseShape> = {}): GatewayReleaseShape {
  return { site, current: "1.0.0", phase: "idle", candidate: "", waits: "", fetched: 0, failed: {}, ...change };
}

function releases(stages: readonly RolloutSiteShape[], change: Partial<ReleaseList> = {}, stopped = ""): ReleaseList {
  const began_us = (Date.now() - 840_000) * 1000;
  const about = { site: "", size: 148_300_000, changed_us: began_us, problem: "" };
  return {
    releases: [{ ...about, name: "talaia-1.1.0.release", version: "1.1.0" }],
    gateways: [gateway("dome", { current: "1.1.0" }), gateway("rover", { phase: "waiting", candidate: "1.1.0", waits: "it is driven, or a command runs" })],
    rollout:
      stages.length === 0
        ? null
        : { version: "1.1.0", who: "ada", began_us, first: 1, at_once: 10, runs: stopped === "", stopped, sites: [...stages] },
    ...change,
  };
}

export const entries: readonly GalleryEntry[] = [
  {
    tag: "t-hub-list",
    wide: true,
    states: [
      {
        name: "three that are well",
        show: () => html`<t-hub-list .list=${{ clustered: true, bus: true, epoch: 4, hubs: HUBS, shards: [], problems: [] }}></t-hub-list>`,
      },
      {
        name: "sites divided among two leads",
        show: () =>
          html`<t-hub-list
            .list=${{
              clustered: true,
              bus: true,
              epoch: 4,
              hubs: [hub("east", "leads", { own: true, shards: ["main"] }), hub("south", "leads", { shards: ["north"] }), hub("west", "waits")],
              shards: [
                { name: "main", lead: "east", sites: ["dome", "rover"] },
                { name: "north", lead: "south", sites: [] },
                { name: "harbour", lead: "", sites: ["crane"] },
              ],
              problems: ["No hub leads the shard harbour"],
            }}
          ></t-hub-list>`,
      },
      {
        name: "one is gone",
        show: () =>
          html`<t-hub-list
            .list=${{
              clustered: true,
              bus: true,
              epoch: 5,
              hubs: [HUBS[0], hub("a machine with a rather long name:8443", "gone", { silent_s: 312 })],
              shards: [],
              problems: ["a machine with a rather long name:8443 has not been heard for 312 s", "No other hub is there to take over"],
            }}
          ></t-hub-list>`,
      },
    ],
  },
  {
    tag: "t-release-list",
    wide: true,
    states: [
      { name: "to be handed out", show: () => html`<t-release-list .list=${releases([])}></t-release-list>` },
      {
        name: "on its way",
        show: () =>
          html`<t-release-list
            .list=${releases([
              { site: "dome", stage: "done", why: "" },
              { site: "rover", stage: "begun", why: "" },
              { site: "a_site_with_a_rather_long_name", stage: "queued", why: "" },
            ])}
          ></t-release-list>`,
      },
      {
        name: "stopped",
        show: () =>
          html`<t-release-list
            .list=${releases(
              [{ site: "dome", stage: "failed", why: "no link to the hub within 180 s" }, { site: "rover", stage: "queued", why: "" }],
              { gateways: [gateway("dome", { failed: { "1.1.0": "no link to the hub within 180 s" } }), gateway("rover", { phase: "fetching", candidate: "1.1.0", fetched: 66_000_000 })] },
              "dome: no link to the hub within 180 s",
            )}
          ></t-release-list>`,
      },
      {
        name: "nobody takes them",
        show: () =>
          html`<t-release-list
            .list=${releases([], {
              gateways: [],
              releases: [{ name: "notes.release", version: "", site: "", size: 812, changed_us: 0, problem: "notes.release is no release, or is not whole: File is not a zip file" }],
            })}
          ></t-release-list>`,
      },
    ],
  },
];
