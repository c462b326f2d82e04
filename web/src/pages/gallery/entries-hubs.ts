/** Hubs that are one, in their states. */

import { html } from "lit";
import type { HubShape } from "../../generated/api.js";
import type { GalleryEntry } from "./entry.js";
import "../gateways/hub-list.js";

function hub(name: string, role: string, change: Partial<HubShape> = {}): HubShape {
  return {
    name, role, version: "0.1.0", own: false, since_us: (Date.now() - 3_700_000) * 1000, cpu: 0.12, memory_bytes: 190e6,
    database_ms: 1.2, gateways: 40, sockets: 12, silent_s: 0, ...change,
  };
}

const HUBS = [hub("east", "leads", { own: true, cpu: 0.61, gateways: 120 }), hub("south", "waits", { gateways: 1, sockets: 1 }), hub("west", "waits")];

export const entries: readonly GalleryEntry[] = [
  {
    tag: "t-hub-list",
    wide: true,
    states: [
      {
        name: "three that are well",
        show: () => html`<t-hub-list .list=${{ clustered: true, bus: true, epoch: 4, hubs: HUBS, problems: [] }}></t-hub-list>`,
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
              problems: ["a machine with a rather long name:8443 has not been heard for 312 s", "No other hub is there to take over"],
            }}
          ></t-hub-list>`,
      },
    ],
  },
];
